#include "core/mesh.hpp"

#include <algorithm>

namespace mien {

std::vector<Surface> Mesh::triangle_surfaces() const {
    std::vector<Surface> surfaces(triangles.size(), Surface::skin);
    for (const MeshPart& part : parts)
        std::fill_n(surfaces.begin() + part.first, part.count, part.surface);
    return surfaces;
}

Points vertex_normals(PointsRef positions, const std::vector<Triangle>& triangles) {
    Points normals = Points::Zero(positions.rows(), 3);
    for (const auto& [a, b, c] : triangles) {
        const Eigen::RowVector3f ab = positions.row(b) - positions.row(a);
        const Eigen::RowVector3f ac = positions.row(c) - positions.row(a);
        const Eigen::RowVector3f area = ab.cross(ac);
        normals.row(a) += area;
        normals.row(b) += area;
        normals.row(c) += area;
    }
    for (Eigen::Index i = 0; i < normals.rows(); ++i) {
        const float length = normals.row(i).norm();
        if (length > 0) normals.row(i) /= length;
    }
    return normals;
}

std::vector<std::vector<std::uint32_t>> vertex_neighbours(std::uint32_t V, const std::vector<Triangle>& triangles) {
    std::vector<std::vector<std::uint32_t>> neighbours(V);
    for (const Triangle& t : triangles)
        for (int i = 0; i < 3; ++i) {
            neighbours[t[i]].push_back(t[(i + 1) % 3]);
            neighbours[t[i]].push_back(t[(i + 2) % 3]);
        }
    for (auto& list : neighbours) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    return neighbours;
}

}  // namespace mien
