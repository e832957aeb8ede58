#include "samples/occlusion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mien::samples {
namespace {

constexpr float kEmpty = std::numeric_limits<float>::infinity();

struct Depths {
    int size;
    std::vector<float> low, high;  // nearest to -axis, nearest to +axis

    explicit Depths(int n) : size(n), low(std::size_t(n) * n), high(low.size()) {}
    void clear() {
        std::fill(low.begin(), low.end(), kEmpty);
        std::fill(high.begin(), high.end(), -kEmpty);
    }
    void draw(const Vec3& a, const Vec3& b, const Vec3& c) {
        // Cells whose centre a tiny triangle misses are most of them, so this comes before any other work.
        // Coordinates are positive: truncation is floor, and faster than calling it.
        const float x_low = std::min(std::min(a.x(), b.x()), c.x()),
                    x_high = std::max(std::max(a.x(), b.x()), c.x());
        const int x0 = int(x_low) + 1, x1 = int(x_high);
        if (x0 > x1) return;
        const float y_low = std::min(std::min(a.y(), b.y()), c.y()),
                    y_high = std::max(std::max(a.y(), b.y()), c.y());
        const int y0 = int(y_low) + 1, y1 = int(y_high);
        if (y0 > y1) return;
        const float abx = b.x() - a.x(), aby = b.y() - a.y(), acx = c.x() - a.x(), acy = c.y() - a.y();
        const float area = abx * acy - acx * aby;
        if (std::abs(area) < 1e-9f) return;
        const float scale = 1 / area, abz = (b.z() - a.z()) * scale, acz = (c.z() - a.z()) * scale;
        const float sign = area > 0 ? 1.0f : -1.0f, limit = std::abs(area) * 1.00001f;
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const float dx = float(x) - a.x(), dy = float(y) - a.y();
                const float u = dx * acy - acx * dy, v = abx * dy - dx * aby;
                if (u * sign < 0 || v * sign < 0 || (u + v) * sign > limit) continue;
                const float z = a.z() + u * abz + v * acz;
                const std::size_t i = std::size_t(y) * size + x;
                low[i] = std::min(low[i], z);
                high[i] = std::max(high[i], z);
            }
    }
};

// Evenly spread over the half sphere (golden spiral); no axis lies in a coordinate plane, so symmetric meshes
// never meet the buffer edge-on.
std::vector<Vec3> half_sphere(int count) {
    std::vector<Vec3> axes;
    for (int i = 0; i < count; ++i) {
        const float z = 1 - (float(i) + 0.5f) / float(count), r = std::sqrt(1 - z * z),
                    phi = 2.3999632f * float(i) + 0.37f;
        axes.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
    }
    return axes;
}

}  // namespace

Occlusion::Occlusion(PointsRef rest, std::vector<Triangle> blockers, int axes, int resolution)
    : blockers_(std::move(blockers)), resolution_(resolution) {
    if (rest.rows() == 0) return;
    for (const Vec3& axis : half_sphere(axes)) {
        View view{axis.unitOrthogonal(), {}, axis, 0, 0, 0};
        view.up = axis.cross(view.side);
        const Eigen::VectorXf x = rest * view.side, y = rest * view.up;
        const float span = std::max({x.maxCoeff() - x.minCoeff(), y.maxCoeff() - y.minCoeff(), 1e-3f});
        const float room = 0.06f * span;  // for what the face may do
        view.cell = (span + 2 * room) / float(resolution_ - 3);
        view.x_low = x.minCoeff() - room;
        view.y_low = y.minCoeff() - room;
        views_.push_back(view);
    }
}

Eigen::VectorXf Occlusion::at(PointsRef positions, PointsRef normals, float reach) const {
    const Eigen::Index V = positions.rows();
    Eigen::VectorXf open = Eigen::VectorXf::Zero(V), sky = Eigen::VectorXf::Zero(V);
    Depths depths(resolution_);
    std::vector<Vec3> seen(static_cast<std::size_t>(V));
    const float edge = float(resolution_) - 2;
    for (const auto& [side, up, axis, x_low, y_low, cell] : views_) {
        for (Eigen::Index v = 0; v < V; ++v) {
            const Vec3 p = positions.row(v).transpose();
            seen[std::size_t(v)] = {std::clamp((p.dot(side) - x_low) / cell + 1, 1.0f, edge),
                                    std::clamp((p.dot(up) - y_low) / cell + 1, 1.0f, edge), p.dot(axis)};
        }

        depths.clear();
        for (const auto& [a, b, c] : blockers_) depths.draw(seen[a], seen[b], seen[c]);

        for (Eigen::Index v = 0; v < V; ++v) {
            const Vec3 n = normals.row(v).transpose();
            const float facing = n.dot(axis), weight = std::abs(facing);
            if (weight < 0.02f) continue;
            const float turn = facing > 0 ? 1.0f : -1.0f;
            // Step one cell off the surface, and allow for the depth it gains across a cell.
            const Vec3& s = seen[std::size_t(v)];
            const float x = std::clamp(s.x() + n.dot(side), 0.0f, float(resolution_) - 1.001f);
            const float y = std::clamp(s.y() + n.dot(up), 0.0f, float(resolution_) - 1.001f);
            const float slope = std::sqrt(std::max(0.0f, 1 - facing * facing)) / weight;
            const float depth = s.z() * turn + cell * (weight + std::min(slope, 3.0f) + 0.2f);
            const int ix = int(x), iy = int(y);
            const float fx = x - float(ix), fy = y - float(iy);
            const float* buffer = (turn > 0 ? depths.high : depths.low).data() +
                                  std::size_t(iy) * std::size_t(resolution_) + ix;
            const auto free = [&](float blocker) {
                const float above = blocker * turn - depth;
                return above <= 0 ? 1.0f : above / (reach + above);
            };
            const float below = (1 - fx) * free(buffer[0]) + fx * free(buffer[1]);
            const float over = (1 - fx) * free(buffer[resolution_]) + fx * free(buffer[resolution_ + 1]);
            open[v] += weight * (below + fy * (over - below));
            sky[v] += weight;
        }
    }
    for (Eigen::Index v = 0; v < V; ++v) open[v] = sky[v] > 0 ? open[v] / sky[v] : 1.0f;
    return open;
}

}  // namespace mien::samples
