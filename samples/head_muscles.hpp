#pragma once

#include <vector>

#include "samples/head_mesh.hpp"

namespace mien::samples {

/// Offsets of one ARKit shape at weight 1 where they are not zero, mm.
struct Muscle {
    std::vector<std::uint32_t> vertices;
    std::vector<Vec3> offsets;
};

/// How a vertex lies to the mouth.
struct MouthPlace {
    double x = 0;         ///< mm from the midline, the actor's left > 0
    double along = 0;     ///< |x| over the mouth's half width
    double above = 0;     ///< mm over the line between the lips (continued to the jaw joint)
    double distance = 0;  ///< mm from the line between the corners, in frontal view
    double upper = 0.5;   ///< 1: upper lip's side, 0: lower lip's; in between only beyond the corners
    double lip = 0;       ///< 1 where the lips meet, 0 on their border and outside
    double falloff = 1;   ///< below 1 inside the mouth, where the bag follows the lips less and less
};

std::vector<MouthPlace> mouth_places(const HeadSurface& surface, const HeadMesh& head);

/// The part of every shape that adds up linearly. The hinge of the jaw, lids and eyeballs are not in it;
/// EyeBlink, for one, is empty. Indexed as kArkitNames.
std::vector<Muscle> make_muscles(const HeadMesh& head, const std::vector<MouthPlace>& places);

}  // namespace mien::samples
