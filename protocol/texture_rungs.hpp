#pragma once

#include <cstddef>

#include "protocol/limits.hpp"
#include "protocol/stream.hpp"

namespace mien::protocol {

/// Asks for the finest rung there is.
inline constexpr std::size_t kFinestRung = kMaxSlots;

/// Rung number `wanted` of a texture track, 0 the coarsest: of those that stand alone, in the order in which the track names them.
/// The last of them when there are no more.
const Rung& texture_rung(const Track& track, std::size_t wanted);

/// The number of the finest rung of a texture track of at most `bits_per_second`; the coarsest when all have more.
std::size_t texture_rung_within(const Track& track, double bits_per_second);

/// Texels of a texture rung, as shown.
Rung::Size texture_size(const Track& track, const Rung& rung);

}  // namespace mien::protocol
