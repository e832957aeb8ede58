#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace mien::encoder {

/// For every vertex the one that mirrors it left to right, itself on the plane of symmetry or where there is none; an
/// involution. Empty when the mesh is not built symmetrically.
std::vector<std::uint32_t> find_mirror(const Mesh& mesh);

}  // namespace mien::encoder
