#pragma once

#include <string_view>

#include "core/rational.hpp"

namespace mien {

/// Frames a second that anything is recorded or shown at: what lies beyond is a slip of the hand.
inline constexpr double kLowestFrameRate = 0.01, kHighestFrameRate = 1000;

/// As parse_rational(), from kLowestFrameRate to kHighestFrameRate; the error says what it must be.
Result<Rational> parse_frame_rate(std::string_view text);

}  // namespace mien
