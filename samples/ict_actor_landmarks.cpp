#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "samples/ict_actor_parts.hpp"

namespace mien::samples::ict {
namespace {

using Loop = std::vector<std::uint32_t>;
using Line = Landmarks::Line;

/// The face proper as a graph, with the loops of edges where it ends: eyes, mouth and the outer rim.
struct FaceGraph {
    std::vector<std::vector<std::uint32_t>> neighbours;
    std::vector<Loop> rims;  // each in order around
    std::vector<Triangle> triangles;
};

FaceGraph make_graph(const Mesh& mesh) {
    FaceGraph graph;
    for (const Triangle& t : mesh.triangles)
        if (std::max({t[0], t[1], t[2]}) < kFaceEnd) graph.triangles.push_back(t);
    graph.neighbours = vertex_neighbours(kFaceEnd, graph.triangles);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;  // directed edges
    for (const Triangle& t : graph.triangles)
        for (int c = 0; c < 3; ++c) ++sides[{t[std::size_t(c)], t[std::size_t((c + 1) % 3)]}];
    std::map<std::uint32_t, std::uint32_t> next;
    for (const auto& [edge, count] : sides)
        if (!sides.contains({edge.second, edge.first})) next[edge.first] = edge.second;
    while (!next.empty()) {
        Loop loop;
        for (auto at = next.begin(); at != next.end(); at = next.find(loop.back())) {
            const std::uint32_t to = at->second;
            next.erase(at);
            loop.push_back(to);
        }
        graph.rims.push_back(std::move(loop));
    }
    return graph;
}

Vec3 at(const Mesh& mesh, std::uint32_t v) { return mesh.positions.row(v).transpose(); }

/// Vertices at `steps` edges from a rim, for every step up to `count`.
std::vector<Loop> rings_around(const FaceGraph& graph, const Loop& rim, int count) {
    std::vector<int> distance(kFaceEnd, -1);
    std::vector<Loop> rings{rim};
    for (std::uint32_t v : rim) distance[v] = 0;
    for (int d = 1; d <= count; ++d) {
        rings.emplace_back();
        for (std::uint32_t v : rings[std::size_t(d) - 1])
            for (std::uint32_t n : graph.neighbours[v])
                if (distance[n] < 0) {
                    distance[n] = d;
                    rings.back().push_back(n);
                }
    }
    return rings;
}

/// A ring as two lines between its extremes in x: above and below, from low x to high x.
std::pair<Line, Line> upper_and_lower(const Mesh& mesh, const Loop& ring) {
    const auto by_x = [&](std::uint32_t a, std::uint32_t b) { return mesh.positions(a, 0) < mesh.positions(b, 0); };
    const Vec3 low = at(mesh, *std::min_element(ring.begin(), ring.end(), by_x));
    const Vec3 high = at(mesh, *std::max_element(ring.begin(), ring.end(), by_x));
    Line upper, lower;
    for (std::uint32_t v : ring) {
        const Vec3 p = at(mesh, v);
        if ((p - low).norm() < 1e-4f || (p - high).norm() < 1e-4f) continue;
        const float middle = low.y() + (high.y() - low.y()) * (p.x() - low.x()) / (high.x() - low.x());
        (p.y() > middle ? upper : lower).push_back(p);
    }
    for (Line* line : {&upper, &lower}) {
        line->push_back(low);
        line->push_back(high);
        std::sort(line->begin(), line->end(), [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    }
    return {upper, lower};
}

/// Where the line of sight along -z at (x, y) first meets the face.
Vec3 on_front(const Mesh& mesh, const FaceGraph& graph, float x, float y) {
    Vec3 best(x, y, -std::numeric_limits<float>::max());
    for (const Triangle& t : graph.triangles) {
        const Vec3 a = at(mesh, t[0]), b = at(mesh, t[1]), c = at(mesh, t[2]);
        const float area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
        if (area <= 0) continue;  // seen from behind
        const float wb = ((x - a.x()) * (c.y() - a.y()) - (y - a.y()) * (c.x() - a.x())) / area;
        const float wc = ((b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x())) / area;
        if (wb < 0 || wc < 0 || wb + wc > 1) continue;
        const float z = a.z() + wb * (b.z() - a.z()) + wc * (c.z() - a.z());
        best.z() = std::max(best.z(), z);
    }
    return best;
}

/// Centre and radius of the sphere nearest to the back two thirds of an eyeball (the cornea bulges).
std::pair<Vec3, float> fit_eyeball(const Mesh& mesh, int side) {
    const std::uint32_t first = kEyeball[side][0], count = 770;  // the outer shell
    const auto shell = mesh.positions.middleRows(first, count);
    const float front = shell.col(2).maxCoeff(), back = shell.col(2).minCoeff();
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (std::uint32_t i = 0; i < count; ++i) {
        const Eigen::Vector3d p = shell.row(i).transpose().cast<double>();
        if (p.z() > front - 0.3 * (front - back)) continue;
        const Eigen::Vector4d row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
        normal += row * row.transpose();
        right += row * p.squaredNorm();
    }
    const Eigen::Vector4d x = normal.ldlt().solve(right);
    const Eigen::Vector3d centre = x.head<3>();
    return {centre.cast<float>(), float(std::sqrt(x[3] + centre.squaredNorm()))};
}

}  // namespace

Landmarks find_landmarks(const Mesh& neutral) {
    const FaceGraph graph = make_graph(neutral);
    Landmarks found;
    const Loop* mouth = nullptr;
    const Loop* eyes[2] = {nullptr, nullptr};
    std::size_t longest = 0;
    for (const Loop& rim : graph.rims) longest = std::max(longest, rim.size());
    for (const Loop& rim : graph.rims) {
        if (rim.size() == longest) continue;
        float x = 0;
        for (std::uint32_t v : rim) x += neutral.positions(v, 0) / float(rim.size());
        (std::abs(x) < 10 ? mouth : x < 0 ? eyes[0] : eyes[1]) = &rim;
    }
    assert(mouth && eyes[0] && eyes[1]);

    // Rings run around the mouth from inside the lips outward: they meet on the 7th; the red ends on the 15th above and on
    // the 13th below, both nearer at the corners.
    const std::vector<Loop> rings = rings_around(graph, *mouth, 16);
    std::vector<std::pair<Line, Line>> lips;
    for (const Loop& ring : rings) lips.push_back(upper_and_lower(neutral, ring));
    found.upper_lip_line = lips[7].first;
    found.lower_lip_line = lips[7].second;
    const auto border = [&](bool upper, int ring_in_middle) {
        const int ring_at_corner = 11;
        const Line& reference = upper ? lips[7].first : lips[7].second;
        Line line;
        for (std::size_t i = 0; i < reference.size(); ++i) {
            const float s = float(i) / float(reference.size() - 1);
            const float inward = std::min(1.f, 5 * std::min(s, 1 - s));  // 0 at the corners
            const float ring = ring_at_corner + (float(ring_in_middle) - ring_at_corner) * inward;
            const auto low = std::min(std::size_t(ring), std::size_t(15));
            const auto point = [&](std::size_t r) {
                const Line& l = upper ? lips[r].first : lips[r].second;
                const float x = s * float(l.size() - 1);
                const auto k = std::min(std::size_t(x), l.size() - 2);
                return Vec3(l[k] + (x - float(k)) * (l[k + 1] - l[k]));
            };
            line.push_back(point(low) + (ring - float(low)) * (point(low + 1) - point(low)));
        }
        return line;
    };
    found.upper_lip_outline = border(true, 15);
    found.lower_lip_outline = border(false, 13);

    for (int side : {0, 1}) {
        const auto [centre, radius] = fit_eyeball(neutral, side);
        found.eye_centre[side] = centre;
        found.eye_radius = radius;
        // The third ring is the outer edge of the lids, where the lashes stand.
        auto [upper, lower] = upper_and_lower(neutral, rings_around(graph, *eyes[side], 3)[3]);
        if (side == 0) {  // inner corner first
            std::reverse(upper.begin(), upper.end());
            std::reverse(lower.begin(), lower.end());
        }
        found.upper_lid[side] = upper;
        found.lower_lid[side] = lower;

        const float out = side == 0 ? -1.f : 1.f;
        const float width = std::abs(upper.back().x() - upper.front().x());
        const Vec3 middle = 0.5f * (upper.front() + upper.back());
        // Brow: from above the inner corner, highest over the outer third of the eye, falling to the temple.
        for (int i = 0; i <= 12; ++i) {
            const float s = float(i) / 12;
            const float x = -0.72f + 1.72f * s;
            const float y = 0.96f + 0.42f * s - 0.62f * s * s * s;
            found.brow[side].push_back(on_front(neutral, graph, middle.x() + out * width * x, middle.y() + width * y));
        }
        found.cheek[side] = on_front(neutral, graph, middle.x() + out * 0.55f * width, middle.y() - 1.05f * width);
    }

    // The profile: the middle line from brow to chin.
    const float mouth_y = found.upper_lip_line[found.upper_lip_line.size() / 2].y();
    const float eye_y = found.eye_centre[0].y();
    const auto extreme = [&](float from, float to, bool front) {
        Vec3 best = on_front(neutral, graph, 0, from);
        for (float y = from; y < to; y += 0.5f) {
            const Vec3 p = on_front(neutral, graph, 0, y);
            if (front ? p.z() > best.z() : p.z() < best.z()) best = p;
        }
        return best;
    };
    const float upper_border = found.upper_lip_outline[found.upper_lip_outline.size() / 2].y();
    const float lower_border = found.lower_lip_outline[found.lower_lip_outline.size() / 2].y();
    found.nose_tip = extreme(upper_border, eye_y, true);
    found.glabella = extreme(eye_y + 12, eye_y + 40, true);
    const Vec3 below_nose = extreme(upper_border, found.nose_tip.y() - 6, false);
    const Vec3 fold = extreme(lower_border - 16, lower_border, false);
    found.chin = extreme(fold.y() - 30, fold.y(), true);
    for (int side : {0, 1}) {
        const float out = side == 0 ? -1.f : 1.f;
        const float spread = 0.25f * std::abs(found.nose_tip.y() - mouth_y);
        // The opening is on the underside, above the root of the upper lip.
        const Vec3 wanted(out * spread, below_nose.y() + 8, below_nose.z() + 1);
        std::uint32_t nearest = 0;
        for (std::uint32_t v = 0; v < kFaceEnd; ++v)
            if ((at(neutral, v) - wanted).squaredNorm() < (at(neutral, nearest) - wanted).squaredNorm()) nearest = v;
        found.nostril[side] = at(neutral, nearest);
        std::uint32_t farthest = 0;
        float most = 0;
        for (std::uint32_t v = 0; v < kSkinEnd; ++v) {
            const Vec3 p = at(neutral, v);
            if (p.y() < mouth_y || p.y() > eye_y + 20 || out * p.x() <= most) continue;
            most = out * p.x();
            farthest = v;
        }
        found.ear[side] = at(neutral, farthest);
    }
    return found;
}

}  // namespace mien::samples::ict
