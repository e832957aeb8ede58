#pragma once

#include <optional>

#include "core/mesh.hpp"

namespace mien::render {

/// Where a head and neck fade into the wall, so that their cut is no hard edge; heights in head space, mm.
struct BustFade {
    float gone, whole;   ///< nothing is left at the first, everything at the second and above
};

/// Told from the eyes: chins lie less than 2.2 eye distances below them, and what is farther down is neck. None for meshes
/// without eyes or neck.
std::optional<BustFade> bust_fade(const Mesh& neutral);

}  // namespace mien::render
