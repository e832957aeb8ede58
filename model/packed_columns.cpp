#include "model/packed_columns.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <limits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace mien::model {
namespace {

constexpr std::size_t kTile = PackedColumns::kTile;

void sum_tiles(const std::int16_t* values, const float* factors, std::size_t columns, std::size_t rows, const float* start, float* out) {
    for (std::size_t first = 0; first < rows; first += kTile) {
        const std::size_t count = std::min(kTile, rows - first);
        std::array<float, kTile> sum{};
        std::copy_n(start + first, count, sum.data());
        for (std::size_t j = 0; j < columns; ++j, values += kTile)
            for (std::size_t r = 0; r < kTile; ++r) sum[r] += factors[j] * float(values[r]);
        std::copy_n(sum.data(), count, out + first);
    }
}

#if defined(__x86_64__)
// Whole tiles only. The wider one halves the instructions a number takes, which is what is left once its bytes are few.
__attribute__((target("avx2,fma"))) void sum_avx2(const std::int16_t* values, const float* factors, std::size_t columns, std::size_t rows,
                                                  const float* start, float* out) {
    constexpr std::size_t kWidth = 8, kParts = kTile / kWidth;
    for (std::size_t first = 0; first < rows; first += kTile) {
        __m256 sum[kParts];
        for (std::size_t p = 0; p < kParts; ++p) sum[p] = _mm256_loadu_ps(start + first + p * kWidth);
        for (std::size_t j = 0; j < columns; ++j, values += kTile) {
            const __m256 factor = _mm256_set1_ps(factors[j]);
            for (std::size_t p = 0; p < kParts; ++p) {
                const __m128i narrow = _mm_loadu_si128(reinterpret_cast<const __m128i*>(values + p * kWidth));
                sum[p] = _mm256_fmadd_ps(factor, _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(narrow)), sum[p]);
            }
        }
        for (std::size_t p = 0; p < kParts; ++p) _mm256_storeu_ps(out + first + p * kWidth, sum[p]);
    }
}

__attribute__((target("avx512f"))) void sum_avx512(const std::int16_t* values, const float* factors, std::size_t columns, std::size_t rows,
                                                   const float* start, float* out) {
    constexpr std::size_t kWidth = 16, kParts = kTile / kWidth;
    for (std::size_t first = 0; first < rows; first += kTile) {
        __m512 sum[kParts];
        for (std::size_t p = 0; p < kParts; ++p) sum[p] = _mm512_loadu_ps(start + first + p * kWidth);
        for (std::size_t j = 0; j < columns; ++j, values += kTile) {
            const __m512 factor = _mm512_set1_ps(factors[j]);
            for (std::size_t p = 0; p < kParts; ++p) {
                const __m256i narrow = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(values + p * kWidth));
                sum[p] = _mm512_fmadd_ps(factor, _mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(narrow)), sum[p]);
            }
        }
        for (std::size_t p = 0; p < kParts; ++p) _mm512_storeu_ps(out + first + p * kWidth, sum[p]);
    }
}
#endif

auto* best_sum() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) return sum_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return sum_avx2;
#endif
    return sum_tiles;
}

}  // namespace

PackedColumns PackedColumns::pack(std::span<const std::vector<std::int32_t>> columns, std::span<const double> scales) {
    assert(columns.size() == scales.size());
    PackedColumns packed;
    if (columns.empty()) return packed;
    constexpr std::int32_t least = std::numeric_limits<std::int16_t>::min(), most = std::numeric_limits<std::int16_t>::max();
    for (const auto& column : columns)
        for (const std::int32_t v : column)
            if (v < least || v > most) return packed;
    packed.rows_ = columns.front().size();
    packed.scales_.assign(scales.begin(), scales.end());
    const std::size_t k = columns.size();
    packed.values_.assign((packed.rows_ + kTile - 1) / kTile * kTile * k, 0);
    for (std::size_t j = 0; j < k; ++j) {
        assert(columns[j].size() == packed.rows_);
        for (std::size_t i = 0; i < packed.rows_; ++i)
            packed.values_[(i / kTile * k + j) * kTile + i % kTile] = std::int16_t(columns[j][i]);
    }
    return packed;
}

void PackedColumns::run(Sum add, std::span<const float> start, std::span<const float> weights, std::span<float> out) const {
    assert(start.size() == rows_ && out.size() == rows_ && weights.size() == columns());
    std::array<float, 64> few;
    std::vector<float> many(weights.size() > few.size() ? weights.size() : 0);
    float* factors = many.empty() ? few.data() : many.data();
    for (std::size_t j = 0; j < weights.size(); ++j) factors[j] = weights[j] * scales_[j];
    const std::size_t whole = rows_ / kTile * kTile;
    add(values_.data(), factors, weights.size(), whole, start.data(), out.data());
    sum_tiles(values_.data() + whole * weights.size(), factors, weights.size(), rows_ - whole, start.data() + whole, out.data() + whole);
}

void PackedColumns::sum(std::span<const float> start, std::span<const float> weights, std::span<float> out) const {
    static const Sum best = best_sum();
    run(best, start, weights, out);
}

void PackedColumns::sum_plain(std::span<const float> start, std::span<const float> weights, std::span<float> out) const {
    run(sum_tiles, start, weights, out);
}

}  // namespace mien::model
