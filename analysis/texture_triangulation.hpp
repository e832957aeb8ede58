#pragma once

#include <vector>

#include "core/mesh.hpp"

namespace mien::analysis {

/// The coarse mesh over the markers (Ma et al. 2008, section 4.1): Delaunay triangles in texture space, cut where the skin is:
/// no triangle has two corners that lie close in space but far along the skin, as the two lips and the two lids do, or
/// far apart beside the usual. `neutral` has texture coordinates.
std::vector<Triangle> triangulate_over_texture(const Mesh& neutral, const std::vector<Site>& sites);

}  // namespace mien::analysis
