#include "encoder/mesh_mirror.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace mien::encoder {
namespace {

/// Vertices by cells of space, to find the nearest.
class Cells {
public:
    Cells(PointsRef points, float side) : points_(points), side_(side) {
        for (Eigen::Index v = 0; v < points.rows(); ++v) cells_[key(cell(points.row(v).transpose()))].push_back(std::uint32_t(v));
    }
    /// The nearest vertex within one cell's side, or `none`.
    std::uint32_t nearest(const Vec3& at, std::uint32_t none) const {
        const Eigen::Array3i middle = cell(at);
        float best = side_ * side_;
        std::uint32_t found = none;
        for (int i = 0; i < 27; ++i) {
            const auto in = cells_.find(key(middle + Eigen::Array3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
            if (in == cells_.end()) continue;
            for (const std::uint32_t v : in->second) {
                const float d = (points_.row(v).transpose() - at).squaredNorm();
                if (d < best) best = d, found = v;
            }
        }
        return found;
    }

private:
    Eigen::Array3i cell(const Vec3& at) const { return (at / side_).array().floor().cast<int>(); }
    static std::uint64_t key(const Eigen::Array3i& c) {
        return std::uint64_t(std::uint32_t(c[0]) & 0x1fffff) << 42 | std::uint64_t(std::uint32_t(c[1]) & 0x1fffff) << 21 | (std::uint32_t(c[2]) & 0x1fffff);
    }
    PointsRef points_;
    float side_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace

std::vector<std::uint32_t> find_mirror(const Mesh& mesh) {
    const std::uint32_t V = mesh.vertex_count();
    if (V < 3) return {};
    const float middle = (mesh.positions.col(0).minCoeff() + mesh.positions.col(0).maxCoeff()) / 2;
    const Vec3 extent = mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff();
    const Cells cells(mesh.positions, std::max(1e-3f, extent.maxCoeff() / 40));
    std::vector<std::uint32_t> nearest(V);
    for (std::uint32_t v = 0; v < V; ++v) {
        const Vec3 at = mesh.positions.row(v).transpose();
        nearest[v] = cells.nearest({2 * middle - at.x(), at.y(), at.z()}, v);
    }
    std::vector<std::uint32_t> mirror(V);
    std::uint32_t pairs = 0;
    for (std::uint32_t v = 0; v < V; ++v) {
        mirror[v] = nearest[nearest[v]] == v ? nearest[v] : v;
        pairs += mirror[v] != v;
    }
    if (pairs < V / 2) return {};
    return mirror;
}

}  // namespace mien::encoder
