#include "encoder/marker_triangulation.hpp"

#include <algorithm>
#include <cmath>

#include "core/delaunay.hpp"

namespace mien::encoder {

std::vector<Triangle> triangulate_markers(PointsRef markers) {
    if (markers.rows() < 3) return {};
    // The axis stands behind the face by about its half width, so that cheeks unroll instead of folding over.
    const Eigen::RowVector3f low = markers.colwise().minCoeff(), high = markers.colwise().maxCoeff();
    const float axis_x = (low.x() + high.x()) / 2, axis_z = low.z() - (high.x() - low.x()) / 4;
    const float radius = std::max(1.0f, high.z() - axis_z);
    std::vector<Eigen::Vector2d> unrolled;
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
