#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bench/geometry_codec.hpp"

namespace mien::bench {

/// A clip on a grid of one step: what baselines that code integers are given. Deltas of integers do not drift.
struct QuantisedPoints {
    QuantisedPoints(const GeometryInput& input, double rms);

    float step = 1;
    std::int64_t frames = 0, numbers = 0;
    bool narrow = true;                ///< every number fits 16 bits
    std::vector<std::int32_t> values;  ///< F x numbers

    std::int32_t at(std::int64_t f, std::int64_t i) const { return values[std::size_t(f * numbers + i)]; }
    /// Change since the frame before; since zero in frame 0.
    std::int32_t delta(std::int64_t f, std::int64_t i) const { return f ? at(f, i) - at(f - 1, i) : at(f, i); }
};

constexpr std::uint32_t zigzag(std::int32_t v) {
    return (std::uint32_t(v) << 1) ^ std::uint32_t(v >> 31);
}

// The last step of the baselines' decoders: deltas added up, then floats. Plain loops, compiled for the baseline and for
// AVX2 and chosen at run time. `sums`: the numbers of the frame before, updated. Sixteen-bit sums wrap, which the values'
// own range undoes. Zigzag: 0, -1, 1, -2, ... as 0, 1, 2, 3, ...

/// rows: N points of 3 numbers and a padding one; out: N x 3.
void add_rows(std::span<std::int16_t> sums, const std::int16_t* rows, bool zigzagged, float step, float* out);
void scale_rows(std::span<const std::int16_t> rows, float step, float* out);
/// Rows without padding.
void add_rows(std::span<std::int32_t> sums, const std::int32_t* rows, bool zigzagged, float step, float* out);
void scale_rows(std::span<const std::int32_t> rows, float step, float* out);
/// Zigzag numbers as planes of bytes: all lowest bytes, then all next ones.
void add_planes(std::span<std::int16_t> sums, const std::uint8_t* planes, float step, float* out);
void add_planes(std::span<std::int32_t> sums, const std::uint8_t* planes, float step, float* out);

/// The baseline versions whatever the machine has: the twin that tests compare with.
void use_plain_arithmetic(bool plain);

}  // namespace mien::bench
