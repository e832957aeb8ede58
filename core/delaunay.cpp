#include "core/delaunay.hpp"

#include <algorithm>
#include <array>
#include <map>

namespace mien {
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

}  // namespace

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

}  // namespace mien
