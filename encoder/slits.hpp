#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "core/surface_distance.hpp"

namespace mien::encoder {

/// Above, below or beside a slit (Guenter et al. 1998, section 4.2).
enum class Side : std::int8_t { below = -1, beside = 0, above = 1 };

/// A horizontal slit of the face, the mouth or one eye: skin above it never shares dots with skin below it.
struct Slit {
    std::vector<Vec3> line;   ///< from the actor's right corner to the left, mm, ascending x
    bool mouth = false;
    Vec3 centre = Vec3::Zero();  ///< of the eyeball behind it, mm; not of a mouth
    float radius = 0;            ///< of the eyeball, mm; 0: a mouth
    std::vector<Side> sides;  ///< V, of every vertex
};

/// Slits of a neutral head: eyes from its eyeballs (Surface::eye), the mouth from lips that touch or nearly touch while
/// they are far apart along the skin. A slit that the mesh does not show is left out.
std::vector<Slit> find_slits(const Mesh& neutral, const SurfaceDistance& skin);

}  // namespace mien::encoder
