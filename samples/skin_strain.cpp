#include "samples/skin_strain.hpp"

#include <algorithm>
#include <cmath>

namespace mien::samples {

Strain::Strain(const Mesh& neutral, int passes) : area_(neutral.vertex_count()), passes_(passes) {
    const std::vector<Surface> surfaces = neutral.triangle_surfaces();
    std::vector<Triangle> skin;
    for (std::size_t t = 0; t < neutral.triangles.size(); ++t) {
        if (surfaces[t] != Surface::skin) continue;
        const Triangle& c = neutral.triangles[t];
        const Vec3 ab = (neutral.positions.row(c[1]) - neutral.positions.row(c[0])).transpose();
        const Vec3 ac = (neutral.positions.row(c[2]) - neutral.positions.row(c[0])).transpose();
        const float twice = ab.cross(ac).norm();
        if (!(twice > 1e-6f)) continue;
        Eigen::Matrix2f edges;
        edges << ab.norm(), ab.dot(ac) / ab.norm(), 0, twice / ab.norm();
        rest_.push_back({c, edges.inverse(), twice / 2});
        for (const std::uint32_t v : c) area_[v] += twice / 2;
        skin.push_back(c);
    }
    begin_.push_back(0);
    for (const auto& list : vertex_neighbours(neutral.vertex_count(), skin)) {
        around_.insert(around_.end(), list.begin(), list.end());
        begin_.push_back(std::uint32_t(around_.size()));
    }
}

Strain::Field Strain::at(PointsRef deformed) const {
    const Eigen::Index V = Eigen::Index(area_.size());
    // Beyond these a triangle has folded, and says nothing about blood.
    constexpr float kSmallest = 0.09f, kLargest = 9.0f;
    using Pair = Eigen::Array2f;
    std::vector<Pair> field(static_cast<std::size_t>(V), Pair::Zero()), smoothed(field.size());
    for (const Rest& r : rest_) {
        Eigen::Matrix<float, 3, 2> edges;
        edges.col(0) = (deformed.row(r.corners[1]) - deformed.row(r.corners[0])).transpose();
        edges.col(1) = (deformed.row(r.corners[2]) - deformed.row(r.corners[0])).transpose();
        const Eigen::Matrix<float, 3, 2> gradient = edges * r.edges_inverse;
        const float a = gradient.col(0).squaredNorm(), b = gradient.col(0).dot(gradient.col(1)),
                    c = gradient.col(1).squaredNorm();
        const float middle = (a + c) / 2, spread = std::sqrt((a - c) * (a - c) / 4 + b * b);
        const float small = std::clamp(middle - spread, kSmallest, kLargest);
        const float large = std::clamp(middle + spread, kSmallest, kLargest);
        const Pair strain(0.5f * std::log(small * large), -0.5f * std::log(small));
        for (const std::uint32_t v : r.corners) field[v] += r.area * strain;
    }
    for (std::size_t v = 0; v < field.size(); ++v)
        if (area_[v] > 0) field[v] /= area_[v];
    for (int pass = 0; pass < passes_; ++pass) {
        for (std::size_t v = 0; v < field.size(); ++v) {
            Pair sum = Pair::Zero();
            for (std::uint32_t i = begin_[v]; i < begin_[v + 1]; ++i) sum += field[around_[i]];
            const auto count = float(begin_[v + 1] - begin_[v]);
            smoothed[v] = count > 0 ? Pair(0.4f * field[v] + 0.6f / count * sum) : field[v];
        }
        field.swap(smoothed);
    }
    Field result{Eigen::VectorXf(V), Eigen::VectorXf(V)};
    for (std::size_t v = 0; v < field.size(); ++v) {
        result.growth[Eigen::Index(v)] = field[v][0];
        result.squeeze[Eigen::Index(v)] = std::max(0.0f, field[v][1]);
    }
    return result;
}

}  // namespace mien::samples
