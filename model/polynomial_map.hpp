#pragma once

#include <vector>

#include "core/image.hpp"
#include "model/domain_map.hpp"

namespace mien::model {

/// Terms of a polynomial in d1, d2 up to a degree, in the order of the coefficient planes: 1; d1, d2; d1², d1 d2, d2²; d1³, d1² d2,
/// d1 d2², d2³. (In Ma et al. 2008, equation 1, a5; a3, a4; a0, a2, a1.)
enum class PolynomialOrder : std::uint8_t { constant = 0, linear = 1, biquadratic = 2, bicubic = 3 };
constexpr int term_count(PolynomialOrder order) { return (int(order) + 1) * (int(order) + 2) / 2; }
inline constexpr int kMaxTerms = term_count(PolynomialOrder::bicubic);

/// All ten terms at (d1, d2).
template <typename T>
void polynomial_terms(T d1, T d2, T* out) {
    const T terms[kMaxTerms] = {1, d1, d2, d1 * d1, d1 * d2, d2 * d2, d1 * d1 * d1, d1 * d1 * d2, d1 * d2 * d2, d2 * d2 * d2};
    for (int k = 0; k < kMaxTerms; ++k) out[k] = terms[k];
}

/// Per-texel polynomials over a domain: displacements in mm, or linear albedo (a PTM).
struct PolynomialMap {
    int channels = 1;
    PolynomialOrder order = PolynomialOrder::biquadratic;
    std::size_t texels = 0;      ///< of the domain
    std::vector<float> planes;   ///< [channels][terms][texels]

    PolynomialMap() = default;
    PolynomialMap(int channel_count, PolynomialOrder degree, std::size_t domain)
        : channels(channel_count), order(degree), texels(domain), planes(std::size_t(channel_count) * term_count(degree) * domain) {}
    float* plane(int channel, int term) { return planes.data() + (std::size_t(channel) * term_count(order) + term) * texels; }
    const float* plane(int channel, int term) const { return planes.data() + (std::size_t(channel) * term_count(order) + term) * texels; }
};

/// The map's values at every texel of its domain for one frame: out[channel][texel], channels * texels floats. d1 and d2 are
/// evaluated on the way. Chooses AVX2 where the processor has it.
void evaluate(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out);
/// Its plain twin, and the test's truth.
void evaluate_plain(const PolynomialMap& map, const DomainMap& domain, const DomainParameters& parameters, float* out);

/// Values [channel][texel] of a domain as a picture of floats; texels outside get `outside`.
FloatMap spread(const DomainMap& domain, int channels, const float* values, float outside = 0);

}  // namespace mien::model
