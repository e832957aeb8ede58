#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/mesh.hpp"

namespace mien {

/// The Delaunay triangulation of points in a plane (Bowyer 1981, Watson 1981); counter-clockwise triangles. Quadratic in the
/// number of points, which some hundred markers do not feel. At least one point.
std::vector<Triangle> delaunay(std::vector<Eigen::Vector2d> points);

}  // namespace mien
