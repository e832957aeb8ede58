#pragma once

#include <array>
#include <vector>

#include "encoder/slits.hpp"

namespace mien::encoder {

/// Vertices of the upper and the lower margin of an eye that lie one over the other, from the actor's right to the left. Empty where
/// the lids are not open.
std::vector<std::array<std::uint32_t, 2>> lid_margins(const Mesh& neutral, const SurfaceDistance& skin, const Slit& eye);

}  // namespace mien::encoder
