#include "encoder/marker_triangulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace mien::encoder {
namespace {

using Vec2d = Eigen::Vector2d;

/// > 0 when c lies left of the line from a to b.
double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

bool in_circumcircle(const Vec2d& a, const Vec2d& b, const Vec2d& c, const Vec2d& p) {
    const Vec2d pa = a - p, pb = b - p, pc = c - p;
    const double det = pa.squaredNorm() * (pb.x() * pc.y() - pc.x() * pb.y()) - pb.squaredNorm() * (pa.x() * pc.y() - pc.x() * pa.y()) +
                       pc.squaredNorm() * (pa.x() * pb.y() - pb.x() * pa.y());
    return det > 0;
}

/// Bowyer 1981, Watson 1981; counter-clockwise triangles. Quadratic, which some hundred markers do not feel.
std::vector<Triangle> delaunay(std::vector<Vec2d> points) {
    const auto N = std::uint32_t(points.size());
    Vec2d low = points[0], high = points[0];
    for (const Vec2d& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const Vec2d centre = (low + high) / 2;
    const double size = 50 * std::max(1.0, (high - low).norm());
    points.push_back(centre + Vec2d(-size, -size));
    points.push_back(centre + Vec2d(size, -size));
    points.push_back(centre + Vec2d(0, size));
    std::vector<Triangle> triangles = {{N, N + 1, N + 2}};
    for (std::uint32_t i = 0; i < N; ++i) {
        std::map<std::array<std::uint32_t, 2>, int> edges;
        std::erase_if(triangles, [&](const Triangle& t) {
            if (!in_circumcircle(points[t[0]], points[t[1]], points[t[2]], points[i])) return false;
            for (int e = 0; e < 3; ++e) ++edges[{t[e], t[(e + 1) % 3]}];
            return true;
        });
        for (const auto& [edge, count] : edges)
            if (!edges.contains({edge[1], edge[0]}) && turn(points[edge[0]], points[edge[1]], points[i]) > 0)
                triangles.push_back({edge[0], edge[1], i});
    }
    std::erase_if(triangles, [&](const Triangle& t) { return t[0] >= N || t[1] >= N || t[2] >= N; });
    return triangles;
}

}  // namespace

std::vector<Triangle> triangulate_markers(PointsRef markers) {
    if (markers.rows() < 3) return {};
    // The axis stands behind the face by about its half width, so that cheeks unroll instead of folding over.
    const Eigen::RowVector3f low = markers.colwise().minCoeff(), high = markers.colwise().maxCoeff();
    const float axis_x = (low.x() + high.x()) / 2, axis_z = low.z() - (high.x() - low.x()) / 4;
    const float radius = std::max(1.0f, high.z() - axis_z);
    std::vector<Vec2d> unrolled;
    for (Eigen::Index i = 0; i < markers.rows(); ++i)
        unrolled.emplace_back(radius * std::atan2(markers(i, 0) - axis_x, markers(i, 2) - axis_z), markers(i, 1));
    std::vector<Triangle> triangles = delaunay(std::move(unrolled));

    std::vector<float> lengths;
    const auto longest = [&](const Triangle& t) {
        float most = 0;
        for (int e = 0; e < 3; ++e) most = std::max(most, (markers.row(t[e]) - markers.row(t[(e + 1) % 3])).norm());
        return most;
    };
    for (const Triangle& t : triangles) lengths.push_back(longest(t));
    if (lengths.empty()) return {};
    std::nth_element(lengths.begin(), lengths.begin() + long(lengths.size() / 2), lengths.end());
    const float limit = 3 * lengths[lengths.size() / 2];
    std::erase_if(triangles, [&](const Triangle& t) { return longest(t) > limit; });
    return triangles;
}

}  // namespace mien::encoder
