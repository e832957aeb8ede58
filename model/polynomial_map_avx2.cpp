#include "model/polynomial_map_avx2.hpp"

#include <cassert>

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

template <int kTerms>
MIEN_AVX2 void run_all(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out) {
    const std::size_t n = map.texels;
    for (const DomainMap::Run& run : domain.runs) {
        const Eight q1 = broadcast(parameters.d1[run.triangle]), q2 = broadcast(parameters.d2[run.triangle]);
        std::uint32_t i = run.begin;
        for (; i + 8 <= run.end; i += 8) {
            const __m256 b1 = _mm256_loadu_ps(domain.b1.data() + i), b2 = _mm256_loadu_ps(domain.b2.data() + i);
            const __m256 d1 = at(q1, b1, b2), d2 = at(q2, b1, b2);
            for (int c = 0; c < map.channels; ++c)
                _mm256_storeu_ps(out + std::size_t(c) * n + i, polynomial<kTerms>(map.plane(c, 0) + i, n, d1, d2));
        }
        for (; i < run.end; ++i) {
            float x[kMaxTerms];
            polynomial_terms(parameters.d1[run.triangle].at(domain.b1[i], domain.b2[i]),
                             parameters.d2[run.triangle].at(domain.b1[i], domain.b2[i]), x);
            for (int c = 0; c < map.channels; ++c) {
                float sum = 0;
                for (int k = 0; k < kTerms; ++k) sum += map.plane(c, k)[i] * x[k];
                out[std::size_t(c) * n + i] = sum;
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
