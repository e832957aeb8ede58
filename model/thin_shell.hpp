#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "core/mesh.hpp"

namespace mien::model {

/// The Laplacian of a mesh in two parts: its cotangent stiffness C (V x V, symmetric, rows sum to zero, mm^0) and the lumped
/// area of every vertex (a third of its triangles', mm^2). The mass-normalised Laplacian is -diag(1 / area) C. Only triangles
/// listed count; vertices of none have an empty row and area 0. Cotangents of needle triangles are bounded.
struct MeshLaplacian {
    Eigen::SparseMatrix<double> stiffness;
    Eigen::VectorXd area;
};
MeshLaplacian mesh_laplacian(PointsRef positions, const std::vector<Triangle>& triangles);

struct ThinShellOptions {
    double stretching = 1;    ///< k_s
    double bending = 100;     ///< k_b, mm^2: bending rules below a wavelength of about 2 pi sqrt(k_b / k_s)
};

/// What a linear thin shell makes of its markers (Bickel et al. 2007; Ma et al. 2008, section 4): the displacement x that
/// solves (-k_s Δ + k_b Δ²) x = 0 where markers do not hold it, is exactly the markers' at their sites, and zero at the `fixed`
/// vertices. It is linear in the markers, so x = R m with R (V x M), the same for all three coordinates. Only the skin
/// (`surfaces`, bit s: Surface(s)) that hangs together with a marker or a fixed vertex takes part: other rows are zero. At open
/// borders x has no slope across the border.
/// Two markers at one place share its displacement. A mesh so broken that nothing solves it stays still (all zero). sites.size() >= 1.
Eigen::MatrixXf thin_shell_response(const Mesh& neutral, const std::vector<Site>& sites, const std::vector<std::uint32_t>& fixed,
                                    std::uint32_t surfaces = 1u << int(Surface::skin), const ThinShellOptions& options = {});

}  // namespace mien::model
