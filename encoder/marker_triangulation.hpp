#pragma once

#include <vector>

#include "core/mesh.hpp"

namespace mien::encoder {

/// A surface over scattered markers, for showing a clip that has no mesh: Delaunay triangles of the markers unrolled from a
/// vertical cylinder behind the face, without those whose sides are far longer than usual. Wound outward (+z).
std::vector<Triangle> triangulate_markers(PointsRef markers);

}  // namespace mien::encoder
