#include "model/packed_columns.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace mien::model {
namespace {

constexpr std::size_t kTile = PackedColumns::kTile;
constexpr float kFactor = 32767;           // an integer factor's largest
constexpr float kSum = float(1 << 30);     // and a sum's
constexpr float kSeen = 32;                // see sum()

/// A frame's factors: coarse * unit + fine * fine_unit, those of two columns in each 32 bits as they are multiplied.
struct Factors {
    std::vector<std::int32_t> coarse, fine;   // by pair
    float unit = 0, fine_unit = 0;
    bool all_fine = false;                    // or the fine parts of columns of 8 bits say nothing
};

/// What is known of the columns' sizes keeps every sum below 2^31.
Factors integer_factors(const std::vector<float>& factors, const std::vector<float>& reach, const std::vector<float>& narrow_reach) {
    float most = 0, sum = 0, reaches = 0, narrow = 0;
    for (std::size_t j = 0; j < factors.size(); ++j) {
        most = std::max(most, std::abs(factors[j]));
        sum += std::abs(factors[j]) * reach[j];
        reaches += reach[j];
        narrow += narrow_reach[j];
    }
    Factors out;
    // What is not finite, or not when summed, must not become an integer.
    out.unit = std::isfinite(sum) ? std::max(most / kFactor, sum / kSum) : std::numeric_limits<float>::quiet_NaN();
    out.fine_unit = out.unit / 2 * std::max(1 / kFactor, reaches / kSum);
    out.all_fine = out.unit / 2 * narrow > most / kSeen;
    const bool still = !(out.fine_unit > std::numeric_limits<float>::min());   // nothing moves, or less than a float can say
    out.coarse.resize((factors.size() + 1) / 2);
    out.fine.resize(out.coarse.size());
    for (std::size_t j = 0; j < factors.size() && !still; ++j) {
        const float coarse = std::round(factors[j] / out.unit);
        const float fine = std::clamp(std::round((factors[j] - coarse * out.unit) / out.fine_unit), -kFactor, kFactor);
        const int shift = j % 2 == 0 ? 0 : 16;
        out.coarse[j / 2] |= std::int32_t(std::uint32_t(std::uint16_t(std::int16_t(coarse))) << shift);
        out.fine[j / 2] |= std::int32_t(std::uint32_t(std::uint16_t(std::int16_t(fine))) << shift);
    }
    return out;
}

constexpr std::size_t kWideBytes = 4 * kTile, kNarrowBytes = 2 * kTile;   // of a pair in a tile

bool is_wide(std::int32_t v) { return v < std::numeric_limits<std::int8_t>::min() || v > std::numeric_limits<std::int8_t>::max(); }

/// The 2 kTile numbers of a pair; returns where the next pair is.
const std::int8_t* unpack(const std::int8_t* at, bool wide, std::int16_t* out) {
    if (wide) std::memcpy(out, at, kWideBytes);
    else std::copy_n(at, 2 * kTile, out);
    return at + (wide ? kWideBytes : kNarrowBytes);
}

void pack_pair(const std::int16_t* numbers, bool wide, std::vector<std::int8_t>& out) {
    const auto* bytes = reinterpret_cast<const std::int8_t*>(numbers);
    if (wide) out.insert(out.end(), bytes, bytes + kWideBytes);
    else
        for (std::size_t i = 0; i < 2 * kTile; ++i) out.push_back(std::int8_t(numbers[i]));
}

/// Sums one tile whose first `wide` pairs have 16 bits; returns where the next one's numbers are.
using TileSum = const std::int8_t* (*)(const std::int8_t* values, const Factors& factors, std::size_t wide, const float* start, float* out);

const std::int8_t* sum_tile(const std::int8_t* values, const Factors& factors, std::size_t wide, const float* start, float* out) {
    std::int32_t coarse[kTile] = {}, fine[kTile] = {};
    const auto add = [](const std::int16_t* numbers, std::int32_t pair, std::int32_t* sums) {
        const int first = std::int16_t(pair & 0xffff), second = pair >> 16;
        for (std::size_t r = 0; r < kTile; ++r) sums[r] += numbers[2 * r] * first + numbers[2 * r + 1] * second;
    };
    for (std::size_t p = 0; p < factors.coarse.size(); ++p) {
        std::int16_t here[2 * kTile];
        values = unpack(values, p < wide, here);
        add(here, factors.coarse[p], coarse);
        if (p < wide || factors.all_fine) add(here, factors.fine[p], fine);
    }
    for (std::size_t r = 0; r < kTile; ++r) out[r] = start[r] + (float(coarse[r]) * factors.unit + float(fine[r]) * factors.fine_unit);
    return values;
}

#if defined(__x86_64__)
__attribute__((target("avx2"), always_inline)) inline void add(__m256i& sums, __m256i numbers, __m256i by) {
    sums = _mm256_add_epi32(sums, _mm256_madd_epi16(numbers, by));
}

__attribute__((target("avx2"), always_inline)) inline void move(const float* start, __m256i coarse, __m256i fine, const Factors& factors, float* out) {
    const __m256 by = _mm256_add_ps(_mm256_mul_ps(_mm256_cvtepi32_ps(coarse), _mm256_set1_ps(factors.unit)),
                                    _mm256_mul_ps(_mm256_cvtepi32_ps(fine), _mm256_set1_ps(factors.fine_unit)));
    _mm256_storeu_ps(out, _mm256_add_ps(_mm256_loadu_ps(start), by));
}

// A product of two pairs is one instruction for 16 numbers. Without fused multiplication, as everywhere: the same bits.
template <bool kAllFine>
__attribute__((target("avx2"))) const std::int8_t* sum_tile_avx2(const std::int8_t* values, const Factors& factors, std::size_t wide, const float* start, float* out) {
    static_assert(kTile == 32);
    __m256i c0 = _mm256_setzero_si256(), c1 = c0, c2 = c0, c3 = c0, f0 = c0, f1 = c0, f2 = c0, f3 = c0;   // named: arrays would live in memory
    const std::int32_t *coarse = factors.coarse.data(), *fine = factors.fine.data();
    const std::size_t pairs = factors.coarse.size();
    std::size_t p = 0;
    for (; p < wide; ++p, values += kWideBytes) {
        const auto* here = reinterpret_cast<const __m256i*>(values);
        const __m256i v0 = _mm256_loadu_si256(here), v1 = _mm256_loadu_si256(here + 1), v2 = _mm256_loadu_si256(here + 2), v3 = _mm256_loadu_si256(here + 3);
        const __m256i by = _mm256_set1_epi32(coarse[p]), by_fine = _mm256_set1_epi32(fine[p]);
        add(c0, v0, by), add(c1, v1, by), add(c2, v2, by), add(c3, v3, by);
        add(f0, v0, by_fine), add(f1, v1, by_fine), add(f2, v2, by_fine), add(f3, v3, by_fine);
    }
    for (; p < pairs; ++p, values += kNarrowBytes) {
        const auto* here = reinterpret_cast<const __m128i*>(values);
        const __m256i v0 = _mm256_cvtepi8_epi16(_mm_loadu_si128(here)), v1 = _mm256_cvtepi8_epi16(_mm_loadu_si128(here + 1)),
                      v2 = _mm256_cvtepi8_epi16(_mm_loadu_si128(here + 2)), v3 = _mm256_cvtepi8_epi16(_mm_loadu_si128(here + 3));
        const __m256i by = _mm256_set1_epi32(coarse[p]);
        add(c0, v0, by), add(c1, v1, by), add(c2, v2, by), add(c3, v3, by);
        if constexpr (kAllFine) {
            const __m256i by_fine = _mm256_set1_epi32(fine[p]);
            add(f0, v0, by_fine), add(f1, v1, by_fine), add(f2, v2, by_fine), add(f3, v3, by_fine);
        }
    }
    move(start, c0, f0, factors, out);
    move(start + 8, c1, f1, factors, out + 8);
    move(start + 16, c2, f2, factors, out + 16);
    move(start + 24, c3, f3, factors, out + 24);
    return values;
}
#endif

TileSum best_sum([[maybe_unused]] bool all_fine) {
#if defined(__x86_64__)
    static const bool wide = __builtin_cpu_supports("avx2");
    if (wide) return all_fine ? sum_tile_avx2<true> : sum_tile_avx2<false>;
#endif
    return sum_tile;
}

}  // namespace

PackedColumns PackedColumns::pack(std::span<const std::vector<std::int32_t>> columns, std::span<const double> scales) {
    assert(columns.size() == scales.size());
    PackedColumns packed;
    if (columns.empty()) return packed;
    for (const auto& column : columns) {
        const auto [least, most] = std::minmax_element(column.begin(), column.end());
        if (!column.empty() && (*least < std::numeric_limits<std::int16_t>::min() || *most > std::numeric_limits<std::int16_t>::max())) return {};
        packed.reach_.push_back(column.empty() ? 0 : std::max(std::abs(float(*least)), std::abs(float(*most))));
    }
    const std::size_t rows = columns.front().size(), pairs = (columns.size() + 1) / 2, tiles = (rows + kTile - 1) / kTile;
    packed.rows_ = rows;
    packed.scales_.assign(scales.begin(), scales.end());
    const auto number = [&](std::size_t column, std::size_t row) { return column < columns.size() && row < rows ? columns[column][row] : 0; };

    // Columns come by what they move, so that the first ones have the large numbers: bits only fall from pair to pair.
    packed.tiles_.resize(tiles);
    for (std::size_t t = 0; t < tiles; ++t)
        for (std::size_t c = 0; c < columns.size(); ++c)
            for (std::size_t r = t * kTile; r < (t + 1) * kTile; ++r)
                if (is_wide(number(c, r))) packed.tiles_[t].wide = std::uint32_t(c / 2 + 1);
    packed.narrow_reach_.resize(columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c)
        for (std::size_t r = 0; r < rows; ++r)
            if (c / 2 >= packed.tiles_[r / kTile].wide) packed.narrow_reach_[c] = std::max(packed.narrow_reach_[c], std::abs(float(columns[c][r])));
    // Tiles alike lie together, as a processor guesses well what it does many times. The last, if not whole, stays behind.
    const std::size_t whole = rows / kTile;
    const auto wide = [&](std::uint32_t t) { return packed.tiles_[t].wide; };
    packed.order_.resize(tiles);
    std::iota(packed.order_.begin(), packed.order_.end(), 0u);
    std::stable_sort(packed.order_.begin(), packed.order_.begin() + std::ptrdiff_t(whole), [&](std::uint32_t a, std::uint32_t b) { return wide(a) < wide(b); });
    for (std::size_t k = 0; k < tiles; ++k) {
        const std::uint32_t t = packed.order_[k];
        if (k < whole) {
            if (k == 0 || wide(packed.order_[k - 1]) != wide(t)) packed.runs_.push_back({0, wide(t)});
            ++packed.runs_.back().tiles;
        }
        packed.tiles_[t].at = std::uint32_t(packed.values_.size());
        for (std::size_t p = 0; p < pairs; ++p) {
            std::int16_t here[2 * kTile];
            for (std::size_t i = 0; i < 2 * kTile; ++i) here[i] = std::int16_t(number(2 * p + i % 2, t * kTile + i / 2));
            pack_pair(here, p < wide(t), packed.values_);
        }
    }
    return packed;
}

void PackedColumns::run(bool portable, std::span<const float> start, std::span<const float> weights, std::span<float> out) const {
    assert(start.size() == rows_ && out.size() == rows_ && weights.size() == columns());
    std::vector<float> products(weights.size());
    for (std::size_t j = 0; j < products.size(); ++j) products[j] = weights[j] * scales_[j];
    const Factors factors = integer_factors(products, reach_, narrow_reach_);
    const TileSum best = portable ? sum_tile : best_sum(factors.all_fine);
    const std::int8_t* at = values_.data();
    const std::uint32_t* tile = order_.data();
    for (const Run& run : runs_)
        for (std::uint32_t k = 0; k < run.tiles; ++k, ++tile) at = best(at, factors, run.wide, start.data() + *tile * kTile, out.data() + *tile * kTile);
    const std::size_t whole = rows_ / kTile * kTile;
    if (whole == rows_) return;
    float last_start[kTile] = {}, last[kTile];
    std::copy(start.begin() + std::ptrdiff_t(whole), start.end(), last_start);
    best(at, factors, tiles_.back().wide, last_start, last);
    std::copy_n(last, rows_ - whole, out.begin() + std::ptrdiff_t(whole));
}

void PackedColumns::sum(std::span<const float> start, std::span<const float> weights, std::span<float> out) const { run(false, start, weights, out); }
void PackedColumns::sum_portable(std::span<const float> start, std::span<const float> weights, std::span<float> out) const { run(true, start, weights, out); }

void PackedColumns::sum_plain(std::span<const float> start, std::span<const float> weights, std::span<float> out) const {
    assert(start.size() == rows_ && out.size() == rows_ && weights.size() == columns());
    for (std::size_t first = 0; first < rows_; first += kTile) {
        const Tile& tile = tiles_[first / kTile];
        const std::int8_t* at = values_.data() + tile.at;
        const std::size_t count = std::min(kTile, rows_ - first);
        float sum[kTile];
        std::copy_n(start.begin() + std::ptrdiff_t(first), count, sum);
        for (std::size_t j = 0; j < weights.size(); ++j) {
            std::int16_t here[2 * kTile];
            const std::int8_t* next = unpack(at, j / 2 < tile.wide, here);
            for (std::size_t r = 0; r < count; ++r) sum[r] += weights[j] * scales_[j] * float(here[2 * r + j % 2]);
            if (j % 2 == 1) at = next;
        }
        std::copy_n(sum, count, out.begin() + std::ptrdiff_t(first));
    }
}

}  // namespace mien::model
