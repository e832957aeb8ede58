#include "bench/quantised_points.hpp"

#include <atomic>
#include <cmath>
#include <cstring>

namespace mien::bench {
namespace {

std::atomic<bool> plain_only{false};

bool use_avx2() {
#if defined(__x86_64__)
    static const bool has = __builtin_cpu_supports("avx2");
    return has && !plain_only;
#else
    return false;
#endif
}

#define MIEN_INLINE [[gnu::always_inline]] inline

template <class Integer>
MIEN_INLINE Integer from_zigzag(Integer v) {
    using Unsigned = std::make_unsigned_t<Integer>;
    const auto u = Unsigned(v);
    return Integer(Unsigned(u >> 1) ^ Unsigned(Unsigned(0) - Unsigned(u & 1)));
}

template <class Integer>
MIEN_INLINE void add(Integer* sums, const Integer* rows, std::size_t count, bool zigzagged) {
    using Unsigned = std::make_unsigned_t<Integer>;
    if (zigzagged)
        for (std::size_t i = 0; i < count; ++i) sums[i] = Integer(Unsigned(sums[i]) + Unsigned(from_zigzag(rows[i])));
    else
        for (std::size_t i = 0; i < count; ++i) sums[i] = Integer(Unsigned(sums[i]) + Unsigned(rows[i]));
}

template <class Integer>
MIEN_INLINE void to_floats(const Integer* values, std::size_t count, float step, float* out) {
    for (std::size_t i = 0; i < count; ++i) out[i] = float(values[i]) * step;
}

// Points of 3 numbers and padding: a whole row is written where the next one will overwrite its padding.
MIEN_INLINE void to_points(const std::int16_t* rows, std::size_t count, float step, float* out) {
    const std::size_t points = count / 4;
    float row[4];
    for (std::size_t p = 0; p + 1 < points; ++p) {
        for (int c = 0; c < 4; ++c) row[c] = float(rows[4 * p + c]) * step;
        std::memcpy(out + 3 * p, row, sizeof row);
    }
    if (points)
        for (int c = 0; c < 3; ++c) out[3 * (points - 1) + c] = float(rows[4 * (points - 1) + c]) * step;
}

template <class Integer>
MIEN_INLINE void add_bytes(Integer* sums, const std::uint8_t* planes, std::size_t count) {
    using Unsigned = std::make_unsigned_t<Integer>;
    for (std::size_t i = 0; i < count; ++i) {
        Unsigned value = planes[i];
        for (std::size_t b = 1; b < sizeof(Integer); ++b) value = Unsigned(value | Unsigned(planes[b * count + i]) << 8 * b);
        sums[i] = Integer(Unsigned(sums[i]) + Unsigned(from_zigzag(Integer(value))));
    }
}

}  // namespace

// One body, compiled twice.
#if defined(__x86_64__)
#define MIEN_TWICE(name, parameters, arguments, body)                                          \
    namespace {                                                                                \
    [[gnu::target("avx2")]] void name##_avx2 parameters body void name##_plain parameters body \
    }                                                                                          \
    void name parameters {                                                                     \
        use_avx2() ? name##_avx2 arguments : name##_plain arguments;                           \
    }
#else
#define MIEN_TWICE(name, parameters, arguments, body) void name parameters body
#endif

MIEN_TWICE(add_rows, (std::span<std::int16_t> sums, const std::int16_t* rows, bool zigzagged, float step, float* out),
           (sums, rows, zigzagged, step, out), {
               add(sums.data(), rows, sums.size(), zigzagged);
               to_points(sums.data(), sums.size(), step, out);
           })
MIEN_TWICE(scale_rows, (std::span<const std::int16_t> rows, float step, float* out), (rows, step, out),
           { to_points(rows.data(), rows.size(), step, out); })
MIEN_TWICE(add_rows, (std::span<std::int32_t> sums, const std::int32_t* rows, bool zigzagged, float step, float* out),
           (sums, rows, zigzagged, step, out), {
               add(sums.data(), rows, sums.size(), zigzagged);
               to_floats(sums.data(), sums.size(), step, out);
           })
MIEN_TWICE(scale_rows, (std::span<const std::int32_t> rows, float step, float* out), (rows, step, out),
           { to_floats(rows.data(), rows.size(), step, out); })
MIEN_TWICE(add_planes, (std::span<std::int16_t> sums, const std::uint8_t* planes, float step, float* out),
           (sums, planes, step, out), {
               add_bytes(sums.data(), planes, sums.size());
               to_floats(sums.data(), sums.size(), step, out);
           })
MIEN_TWICE(add_planes, (std::span<std::int32_t> sums, const std::uint8_t* planes, float step, float* out),
           (sums, planes, step, out), {
               add_bytes(sums.data(), planes, sums.size());
               to_floats(sums.data(), sums.size(), step, out);
           })

void use_plain_arithmetic(bool plain) {
    plain_only = plain;
}

QuantisedPoints::QuantisedPoints(const GeometryInput& input, double rms)
    : step(float(input.step(rms))), frames(input.frames), numbers(input.numbers()), values(input.held.size()) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = std::int32_t(std::lround(double(input.held[i]) / step));
        narrow = narrow && values[i] >= -32768 && values[i] <= 32767;
    }
}

}  // namespace mien::bench
