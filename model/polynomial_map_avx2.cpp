#include "model/polynomial_map_avx2.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>

#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>

namespace mien::model {
namespace {

#define MIEN_AVX2 __attribute__((target("avx2,fma")))

struct Eight {
    __m256 c[6];
};

MIEN_AVX2 inline Eight broadcast(const DomainParameters::Quadratic& q) {
    Eight eight;
    for (int k = 0; k < 6; ++k) eight.c[k] = _mm256_set1_ps(q.c[k]);
    return eight;
}

MIEN_AVX2 inline __m256 at(const Eight& q, __m256 b1, __m256 b2) {
    const __m256 inner = _mm256_fmadd_ps(q.c[3], b1, _mm256_fmadd_ps(q.c[4], b2, q.c[1]));
    return _mm256_fmadd_ps(b2, _mm256_fmadd_ps(q.c[5], b2, q.c[2]), _mm256_fmadd_ps(b1, inner, q.c[0]));
}

/// The polynomial whose coefficient k is at plane + k * texels.
template <int kTerms>
MIEN_AVX2 inline __m256 polynomial(const float* plane, std::size_t texels, __m256 d1, __m256 d2) {
    const auto load = [&](int k) MIEN_AVX2 { return _mm256_loadu_ps(plane + std::size_t(k) * texels); };
    if constexpr (kTerms == 1) return load(0);
    __m256 by_d1 = load(1), by_d2 = load(2);
    if constexpr (kTerms >= 6) {
        __m256 by_11 = load(3), by_12 = load(4), by_22 = load(5);
        if constexpr (kTerms >= 10) {
            by_11 = _mm256_fmadd_ps(load(6), d1, _mm256_fmadd_ps(load(7), d2, by_11));
            by_12 = _mm256_fmadd_ps(load(8), d2, by_12);
            by_22 = _mm256_fmadd_ps(load(9), d2, by_22);
        }
        by_d1 = _mm256_fmadd_ps(by_11, d1, _mm256_fmadd_ps(by_12, d2, by_d1));
        by_d2 = _mm256_fmadd_ps(by_22, d2, by_d2);
    }
    return _mm256_fmadd_ps(by_d1, d1, _mm256_fmadd_ps(by_d2, d2, load(0)));
}

/// Texels whose d1, d2 are kept while the channels take their turn: one channel reads kTerms planes at once, which the memory's
/// prefetching follows; all channels' planes together are more streams than it does.
constexpr std::uint32_t kBlock = 512;

template <int kTerms>
MIEN_AVX2 void run_all(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out) {
    const std::size_t n = map.texels;
    alignas(32) float d1[kBlock], d2[kBlock];
    for (const DomainMap::Run& run : domain.runs) {
        const auto &plain1 = parameters.d1[run.triangle], &plain2 = parameters.d2[run.triangle];
        const Eight q1 = broadcast(plain1), q2 = broadcast(plain2);
        for (std::uint32_t begin = run.begin; begin < run.end; begin += kBlock) {
            const std::uint32_t count = std::min(kBlock, run.end - begin), whole = count - count % 8;
            for (std::uint32_t i = 0; i < whole; i += 8) {
                const __m256 b1 = _mm256_loadu_ps(domain.b1.data() + begin + i), b2 = _mm256_loadu_ps(domain.b2.data() + begin + i);
                _mm256_store_ps(d1 + i, at(q1, b1, b2));
                _mm256_store_ps(d2 + i, at(q2, b1, b2));
            }
            for (std::uint32_t i = whole; i < count; ++i) {
                d1[i] = plain1.at(domain.b1[begin + i], domain.b2[begin + i]);
                d2[i] = plain2.at(domain.b1[begin + i], domain.b2[begin + i]);
            }
            for (int c = 0; c < map.channels; ++c) {
                const float* planes = map.plane(c, 0) + begin;
                float* values = out + std::size_t(c) * n + begin;
                for (std::uint32_t i = 0; i < whole; i += 8)
                    _mm256_storeu_ps(values + i, polynomial<kTerms>(planes + i, n, _mm256_load_ps(d1 + i), _mm256_load_ps(d2 + i)));
                for (std::uint32_t i = whole; i < count; ++i) {
                    float x[kMaxTerms];
                    polynomial_terms(d1[i], d2[i], x);
                    float sum = 0;
                    for (int k = 0; k < kTerms; ++k) sum += planes[std::size_t(k) * n + i] * x[k];
                    values[i] = sum;
                }
            }
        }
    }
}

}  // namespace

bool avx2_available() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }

void evaluate_avx2(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out) {
    assert(map.texels == domain.size());
    switch (map.order) {
        case PolynomialOrder::constant: return run_all<1>(map, domain, parameters, out);
        case PolynomialOrder::linear: return run_all<3>(map, domain, parameters, out);
        case PolynomialOrder::biquadratic: return run_all<6>(map, domain, parameters, out);
        case PolynomialOrder::bicubic: return run_all<10>(map, domain, parameters, out);
    }
}

}  // namespace mien::model

#else

namespace mien::model {

bool avx2_available() { return false; }
void evaluate_avx2(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out) {
    evaluate_plain(map, domain, parameters, out);
}

}  // namespace mien::model

#endif
