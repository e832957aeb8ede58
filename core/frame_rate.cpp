#include "core/frame_rate.hpp"

#include <fmt/format.h>

namespace mien {

Result<Rational> parse_frame_rate(std::string_view text) {
    const auto rate = parse_rational(text);
    if (rate && rate->value() >= kLowestFrameRate && rate->value() <= kHighestFrameRate) return rate;
    return Error{ErrorCode::invalid, fmt::format("must be frames per second, from {} to {}, as 30, 29.97 or 30000/1001", kLowestFrameRate, kHighestFrameRate)};
}

}  // namespace mien
