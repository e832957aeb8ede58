#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace mien {

/// An exact fraction, always reduced with den > 0: frame rates (frames per second) and time bases (seconds per tick).
/// No frame rate is ever rounded.
struct Rational {
    std::int64_t num = 0;
    std::int64_t den = 1;

    double value() const { return static_cast<double>(num) / static_cast<double>(den); }
    Rational inverse() const;
    bool operator==(const Rational&) const = default;
};

/// num / den in lowest terms. den != 0.
Rational make_rational(std::int64_t num, std::int64_t den);

/// "30", "29.97" (exactly 2997/100) or "30000/1001"; positive, numerator and denominator at most 2^31 - 1.
Result<Rational> parse_rational(std::string_view text);

/// "30" or "30000/1001".
std::string to_string(Rational r);

/// ticks x from / to, rounded to nearest with halves away from zero; 128-bit inside, so it never overflows for
/// results that fit. Converts a time between two time bases.
std::int64_t rescale(std::int64_t ticks, Rational from, Rational to);

}  // namespace mien
