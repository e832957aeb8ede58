#include "encoder/texture_weight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "core/surface_distance.hpp"
#include "encoder/slits.hpp"

namespace mien::encoder {
namespace {

constexpr std::array kYaws{-45.0f, -22.5f, 0.0f, 22.5f, 45.0f};  // degrees
constexpr std::array kPitches{-20.0f, 0.0f, 20.0f};
constexpr std::int64_t kFrames = 6;   // of the clip that are looked at
constexpr int kDepthSide = 256;       // pixels along the longer side of the depth picture
constexpr float kEmphasis = 1;        // an eye or a mouth counts 1 + this times
constexpr float kFeatureReach = 14;   // mm from the line of an eye or mouth at which half of it is left

struct Axes {
    Vec3 right, above, towards;
};

std::vector<Axes> cameras() {
    std::vector<Axes> all;
    for (const float pitch_degrees : kPitches)
        for (const float yaw_degrees : kYaws) {
            const float yaw = yaw_degrees * float(M_PI) / 180, pitch = pitch_degrees * float(M_PI) / 180;
            const Vec3 towards(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
            const Vec3 right(std::cos(yaw), 0, -std::sin(yaw));
            all.push_back({right, towards.cross(right), towards});
        }
    return all;
}

/// What is seen through.
bool transparent(Surface surface) { return surface == Surface::cornea || surface == Surface::lashes; }

/// The nearest surface along parallel rays.
class DepthPicture {
public:
    DepthPicture(const Mesh& mesh, const std::vector<Surface>& surfaces, PointsRef positions, const Axes& axes) : axes_(axes) {
        Points seen(positions.rows(), 3);
        seen.col(0) = positions * axes.right;
        seen.col(1) = positions * axes.above;
        seen.col(2) = positions * axes.towards;
        low_ = seen.colwise().minCoeff().transpose();
        const Vec3 size = seen.colwise().maxCoeff().transpose() - low_;
        pixel_ = std::max({size.x(), size.y(), 1e-6f}) / float(kDepthSide - 1);
        depth_.assign(std::size_t(kDepthSide) * kDepthSide, -std::numeric_limits<float>::infinity());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            if (!transparent(surfaces[t])) draw(seen, mesh.triangles[t]);
    }

    /// Whether a point of a surface whose normal leans by `cosine` from the ray is the nearest.
    bool sees(const Vec3& point, float cosine) const {
        const int x = int(std::lround((axes_.right.dot(point) - low_.x()) / pixel_));
        const int y = int(std::lround((axes_.above.dot(point) - low_.y()) / pixel_));
        const float slope = std::min(4.0f, std::sqrt(1 - cosine * cosine) / cosine);  // its depth changes so much within a pixel
        return axes_.towards.dot(point) + pixel_ * (1 + slope) >= depth_[std::size_t(y) * kDepthSide + x];
    }

private:
    void draw(const Points& seen, const Triangle& triangle) {
        Vec3 p[3];
        for (int i = 0; i < 3; ++i) {
            const Vec3 q = seen.row(triangle[i]).transpose();
            p[i] = {(q.x() - low_.x()) / pixel_, (q.y() - low_.y()) / pixel_, q.z()};
        }
        const Vec3 a = p[1] - p[0], b = p[2] - p[0];
        const float area = a.x() * b.y() - b.x() * a.y();
        if (!(std::abs(area) > 1e-9f)) return;
        const auto [x_low, x_high] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
        const auto [y_low, y_high] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
        for (int y = int(std::ceil(y_low)); y <= int(y_high); ++y)
            for (int x = int(std::ceil(x_low)); x <= int(x_high); ++x) {
                const float dx = float(x) - p[0].x(), dy = float(y) - p[0].y();
                const float b1 = (dx * b.y() - b.x() * dy) / area, b2 = (a.x() * dy - dx * a.y()) / area;
                if (b1 < 0 || b2 < 0 || b1 + b2 > 1) continue;
                float& depth = depth_[std::size_t(y) * kDepthSide + x];
                depth = std::max(depth, p[0].z() + b1 * a.z() + b2 * b.z());
            }
    }

    Axes axes_;
    Vec3 low_;
    float pixel_;
    std::vector<float> depth_;
};

/// 1 far from eyes and mouth, 1 + kEmphasis on their lines, of every vertex.
std::vector<float> emphasis(const Mesh& mesh) {
    const SurfaceDistance skin(mesh, 1u << int(Surface::skin));
    std::vector<Vec3> lines;
    for (const Slit& slit : find_slits(mesh, skin)) lines.insert(lines.end(), slit.line.begin(), slit.line.end());
    std::vector<float> factor(mesh.vertex_count(), 1);
    parallel_for(std::int64_t(factor.size()), [&](std::int64_t v) {
        float nearest = std::numeric_limits<float>::infinity();
        for (const Vec3& p : lines) nearest = std::min(nearest, (p - mesh.positions.row(v).transpose()).squaredNorm());
        factor[std::size_t(v)] += kEmphasis * std::exp2(-nearest / (kFeatureReach * kFeatureReach));
    });
    return factor;
}

}  // namespace

std::vector<float> seen_area(const Mesh& mesh, PointsRef positions, const TexelMap& map) {
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    std::vector<DepthPicture> pictures;
    const std::vector<Axes> axes = cameras();
    for (const Axes& camera : axes) pictures.emplace_back(mesh, surfaces, positions, camera);

    // Of each triangle: its normal as long as a texel of it is large.
    std::vector<Vec3> facing(mesh.triangles.size());
    for (std::size_t t = 0; t < facing.size(); ++t) {
        Vec3 p[3];
        Vec2 uv[3];
        for (int i = 0; i < 3; ++i) {
            p[i] = positions.row(mesh.triangles[t][i]).transpose();
            uv[i] = mesh.texcoords[mesh.texcoord_triangles[t][i]];
        }
        const Vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
        const float texels = std::abs(a.x() * b.y() - b.x() * a.y()) * float(map.width) * float(map.height);
        const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
        facing[t] = texels > 1e-6f && normal.allFinite() ? Vec3(normal / texels) : Vec3::Zero();
    }
    std::vector<float> seen(map.texels.size());
    parallel_for(map.height, [&](std::int64_t y) {
        for (int x = 0; x < map.width; ++x) {
            const TexelMap::Texel& texel = map.at(x, int(y));
            if (texel.triangle == TexelMap::kNone || transparent(surfaces[texel.triangle])) continue;
            const Triangle& corners = mesh.triangles[texel.triangle];
            const Vec3 point = (1 - texel.b1 - texel.b2) * positions.row(corners[0]).transpose() +
                               texel.b1 * positions.row(corners[1]).transpose() + texel.b2 * positions.row(corners[2]).transpose();
            const Vec3& normal = facing[texel.triangle];
            float sum = 0;
            for (std::size_t c = 0; c < axes.size(); ++c) {
                const float area = normal.dot(axes[c].towards);
                if (area > 0 && pictures[c].sees(point, area / normal.norm())) sum += area;
            }
            seen[std::size_t(y) * map.width + x] = sum / float(axes.size());
        }
    });
    return seen;
}

std::vector<float> texture_weights(const Clip& clip, int width, int height) {
    if (!clip.neutral || !clip.neutral->has_texcoords()) return std::vector<float>(std::size_t(width) * height, 1.0f);
    const Mesh& mesh = *clip.neutral;
    const TexelMap map = make_texel_map(mesh, width, height);
    std::vector<float> weights(map.texels.size());
    const bool moves = clip.vertices && clip.vertices->frames > 0 && clip.vertices->points == mesh.positions.rows();
    const std::int64_t frames = moves ? std::min(kFrames, clip.vertices->frames) : 1;
    for (std::int64_t i = 0; i < frames; ++i) {
        const std::vector<float> seen =
            moves ? seen_area(mesh, clip.vertices->frame((2 * i + 1) * clip.vertices->frames / (2 * frames)), map)
                  : seen_area(mesh, mesh.positions, map);
        for (std::size_t t = 0; t < weights.size(); ++t) weights[t] += seen[t];
    }
    const std::vector<float> factor = emphasis(mesh);
    double sum = 0, count = 0;
    for (std::size_t t = 0; t < weights.size(); ++t) {
        const TexelMap::Texel& texel = map.texels[t];
        if (texel.triangle == TexelMap::kNone) continue;
        const Triangle& corners = mesh.triangles[texel.triangle];
        weights[t] *= (1 - texel.b1 - texel.b2) * factor[corners[0]] + texel.b1 * factor[corners[1]] + texel.b2 * factor[corners[2]];
        sum += weights[t];
        ++count;
    }
    if (!(sum > 0)) return std::vector<float>(weights.size(), 1.0f);
    for (float& weight : weights) weight = float(weight * count / sum);
    return weights;
}

}  // namespace mien::encoder
