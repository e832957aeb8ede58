#pragma once

#include <cstdint>
#include <vector>

#include "core/clip.hpp"
#include "core/texel_map.hpp"

namespace mien::encoder {

/// How much of a viewer's picture each texel of a width x height texture fills: its surface as the usual cameras see it (yaw within
/// 45 degrees of the front, pitch within 20, from afar), foreshortened and with what lies before it taken away, in mean over the
/// cameras and over a few frames of the clip, so that what opens only in the performance (a mouth) counts; more around eyes and
/// mouth. Rows from the top; mean 1 over the texels that show the mesh, 0 for those that do not. All ones without a neutral mesh
/// that has texture coordinates.
std::vector<float> texture_weights(const Clip& clip, int width, int height);

/// The same, not normalised, of one shape of a mesh without the emphasis: mm^2 of picture per texel.
std::vector<float> seen_area(const Mesh& mesh, PointsRef positions, const TexelMap& map);

}  // namespace mien::encoder
