#include "model/thin_shell.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "core/parallel.hpp"

namespace mien::model {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Entry = Eigen::Triplet<double>;

constexpr std::uint32_t kNone = 0xffffffffu;

/// Root of every vertex's piece of the mesh.
std::vector<std::uint32_t> pieces(std::uint32_t V, const std::vector<Triangle>& triangles) {
    std::vector<std::uint32_t> parent(V);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Triangle& t : triangles)
        for (int i = 1; i < 3; ++i) parent[root(t[i])] = root(t[0]);
    for (std::uint32_t v = 0; v < V; ++v) parent[v] = root(v);
    return parent;
}

}  // namespace

MeshLaplacian mesh_laplacian(PointsRef positions, const std::vector<Triangle>& triangles) {
    const Eigen::Index V = positions.rows();
    MeshLaplacian result{Sparse(V, V), Eigen::VectorXd::Zero(V)};
    std::vector<Entry> entries;
    entries.reserve(12 * triangles.size());
    for (const Triangle& t : triangles) {
        Eigen::Vector3d p[3];
        for (int i = 0; i < 3; ++i) p[i] = positions.row(t[i]).transpose().cast<double>();
        const double twice = (p[1] - p[0]).cross(p[2] - p[0]).norm();
        if (!(twice > 1e-12)) continue;
        for (int i = 0; i < 3; ++i) {
            result.area[t[i]] += twice / 6;
            const int j = (i + 1) % 3, k = (i + 2) % 3;  // the edge across corner i
            // Below 3 degrees a triangle says more about the mesh than about the skin.
            const double cotangent = std::clamp((p[j] - p[i]).dot(p[k] - p[i]) / twice, -20.0, 20.0);
            entries.emplace_back(t[j], t[k], -cotangent / 2);
            entries.emplace_back(t[k], t[j], -cotangent / 2);
            entries.emplace_back(t[j], t[j], cotangent / 2);
            entries.emplace_back(t[k], t[k], cotangent / 2);
        }
    }
    result.stiffness.setFromTriplets(entries.begin(), entries.end());
    return result;
}

Eigen::MatrixXf thin_shell_response(const Mesh& neutral, const std::vector<Site>& sites, const std::vector<std::uint32_t>& fixed,
                                    std::uint32_t surfaces, const ThinShellOptions& options) {
    assert(!sites.empty());
    const std::uint32_t V = neutral.vertex_count();
    const auto M = Eigen::Index(sites.size());
    const std::vector<Surface> surface_of = neutral.triangle_surfaces();
    std::vector<Triangle> skin;
    for (std::size_t t = 0; t < neutral.triangles.size(); ++t)
        if (surfaces >> int(surface_of[t]) & 1) skin.push_back(neutral.triangles[t]);
    const MeshLaplacian laplacian = mesh_laplacian(neutral.positions, skin);

    // Unknowns: vertices of held pieces that are not fixed themselves.
    const std::vector<std::uint32_t> piece = pieces(V, skin);
    std::vector<char> held(V, 0), still(V, 0);
    for (const Site& site : sites)
        for (int i = 0; i < 3; ++i)
            if (site.weights[i] != 0) held[piece[site.vertices[i]]] = 1;
    for (const std::uint32_t v : fixed) still[v] = held[piece[v]] = 1;
    std::vector<std::uint32_t> unknown(V, kNone);
    std::uint32_t n = 0;
    for (std::uint32_t v = 0; v < V; ++v)
        if (held[piece[v]] && !still[v] && laplacian.area[v] > 0) unknown[v] = n++;
    Eigen::MatrixXf response = Eigen::MatrixXf::Zero(Eigen::Index(V), M);
    if (n == 0) return response;

    // Energy x' (k_s C + k_b C A^-1 C) x; fixed vertices are zero, so that their columns fall away.
    Eigen::VectorXd inverse_area = laplacian.area;
    for (double& a : inverse_area) a = a > 0 ? 1 / a : 0;
    const Sparse& C = laplacian.stiffness;
    const Sparse energy = options.stretching * C + options.bending * Sparse(C * inverse_area.asDiagonal() * C);
    std::vector<Entry> entries;
    double stiffest = 0;
    for (Eigen::Index column = 0; column < energy.outerSize(); ++column)
        for (Sparse::InnerIterator it(energy, column); it; ++it) {
            if (unknown[std::size_t(it.row())] == kNone || unknown[std::size_t(column)] == kNone) continue;
            entries.emplace_back(unknown[std::size_t(it.row())], unknown[std::size_t(column)], it.value());
            if (it.row() == column) stiffest = std::max(stiffest, it.value());
        }
    std::vector<Entry> hold;  // B: M x n, the markers' displacements from the vertices'
    for (Eigen::Index m = 0; m < M; ++m)
        for (int i = 0; i < 3; ++i) {
            const Site& site = sites[std::size_t(m)];
            if (site.weights[i] != 0 && unknown[site.vertices[i]] != kNone)
                hold.emplace_back(m, unknown[site.vertices[i]], site.weights[i]);
        }
    Sparse B(M, n), system(n, n);
    B.setFromTriplets(hold.begin(), hold.end());
    system.setFromTriplets(entries.begin(), entries.end());
    // The springs at the markers only make the system regular: what they leave is removed below. The last term is for
    // pieces that a single marker would let turn, and far below what the others weigh.
    system += 0.1 * stiffest * Sparse(B.transpose() * B);
    for (std::uint32_t i = 0; i < n; ++i) system.coeffRef(i, i) += 1e-12 * stiffest;
    Eigen::SimplicialLDLT<Sparse> factor(system);
    if (factor.info() != Eigen::Success) return response;

    // (E + w B'B) x = B' c for every c spans the solutions whose energy nothing but the markers holds; B x = m picks c.
    Eigen::MatrixXd free(n, M);
    constexpr Eigen::Index kColumns = 16;
    parallel_for((M + kColumns - 1) / kColumns, [&](std::int64_t block) {
        const Eigen::Index first = block * kColumns, count = std::min(kColumns, M - first);
        free.middleCols(first, count) = factor.solve(Eigen::MatrixXd(Sparse(B.transpose()).middleCols(first, count)));
    });
    Eigen::MatrixXd at_markers = B * free;
    // Markers at one place (or at a fixed vertex) make this singular; the ridge shares the place between them.
    at_markers.diagonal().array() += 1e-9 * at_markers.diagonal().maxCoeff();
    const Eigen::MatrixXd chosen = at_markers.ldlt().solve(Eigen::MatrixXd::Identity(M, M));
    const Eigen::MatrixXf rows = (free * chosen).cast<float>();
    if (!rows.allFinite()) return response;
    for (std::uint32_t v = 0; v < V; ++v)
        if (unknown[v] != kNone) response.row(v) = rows.row(unknown[v]);
    return response;
}

}  // namespace mien::model
