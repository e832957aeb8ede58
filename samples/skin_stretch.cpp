#include "samples/skin_stretch.hpp"

#include <algorithm>
#include <cmath>

namespace mien::samples {

Stretch::Stretch(const Mesh& neutral, int passes) : area_(neutral.vertex_count()), passes_(passes) {
    const std::vector<Surface> surfaces = neutral.triangle_surfaces();
    std::vector<Triangle> skin;
    for (std::size_t t = 0; t < neutral.triangles.size(); ++t) {
        if (surfaces[t] != Surface::skin) continue;
        const Triangle& c = neutral.triangles[t];
        const Vec3 ab = (neutral.positions.row(c[1]) - neutral.positions.row(c[0])).transpose();
        const Vec3 ac = (neutral.positions.row(c[2]) - neutral.positions.row(c[0])).transpose();
        const float twice = ab.cross(ac).norm();
        if (!(twice > 1e-6f)) continue;
        const Vec3 x = ab.normalized(), y = ab.cross(ac).normalized().cross(x);
        Eigen::Matrix2f edges;
        edges << ab.dot(x), ac.dot(x), 0, ac.dot(y);
        rest_.push_back({c, x, y, edges.inverse(), twice / 2});
        for (const std::uint32_t v : c) area_[v] += twice / 2;
        skin.push_back(c);
    }
    begin_.push_back(0);
    for (const auto& list : vertex_neighbours(neutral.vertex_count(), skin)) {
        around_.insert(around_.end(), list.begin(), list.end());
        begin_.push_back(std::uint32_t(around_.size()));
    }
}

Stretch::Field Stretch::at(PointsRef deformed) const {
    Field field = Field::Zero(Eigen::Index(area_.size()), 6), smoothed = field;
    for (const Rest& r : rest_) {
        Eigen::Matrix<float, 3, 2> edges;
        edges.col(0) = (deformed.row(r.corners[1]) - deformed.row(r.corners[0])).transpose();
        edges.col(1) = (deformed.row(r.corners[2]) - deformed.row(r.corners[0])).transpose();
        const Eigen::Matrix<float, 3, 2> gradient = edges * r.edges_inverse;
        const float a = gradient.col(0).squaredNorm(), b = gradient.col(0).dot(gradient.col(1)), c = gradient.col(1).squaredNorm();
        const float middle = (a + c) / 2, spread = std::sqrt((a - c) * (a - c) / 4 + b * b);
        // Beyond a third and threefold a triangle has folded, and says nothing about skin.
        const float small = 0.5f * std::log(std::clamp(middle - spread, 0.11f, 9.0f));
        const float large = 0.5f * std::log(std::clamp(middle + spread, 0.11f, 9.0f));
        // The eigenvector of the larger stretch, at angle t: cos 2t = (a - c) / 2 spread, sin 2t = b / spread.
        const float mean = (large + small) / 2, half = (large - small) / 2;
        const float cos2 = spread > 1e-9f ? (a - c) / (2 * spread) : 0, sin2 = spread > 1e-9f ? b / spread : 0;
        const float xx = mean + half * cos2, yy = mean - half * cos2, xy = half * sin2;
        const Eigen::Matrix3f H = xx * r.x * r.x.transpose() + yy * r.y * r.y.transpose() + xy * (r.x * r.y.transpose() + r.y * r.x.transpose());
        Eigen::Matrix<float, 1, 6> row;
        row << H(0, 0), H(1, 1), H(2, 2), H(0, 1), H(0, 2), H(1, 2);
        for (const std::uint32_t v : r.corners) field.row(v) += r.area * row;
    }
    for (std::size_t v = 0; v < area_.size(); ++v)
        if (area_[v] > 0) field.row(Eigen::Index(v)) /= area_[v];
    for (int pass = 0; pass < passes_; ++pass) {
        for (std::size_t v = 0; v < area_.size(); ++v) {
            const std::uint32_t count = begin_[v + 1] - begin_[v];
            if (count == 0) continue;
            Eigen::Matrix<float, 1, 6> sum = Eigen::Matrix<float, 1, 6>::Zero();
            for (std::uint32_t i = begin_[v]; i < begin_[v + 1]; ++i) sum += field.row(around_[i]);
            smoothed.row(Eigen::Index(v)) = 0.4f * field.row(Eigen::Index(v)) + 0.6f / float(count) * sum;
        }
        field.swap(smoothed);
    }
    return field;
}

}  // namespace mien::samples
