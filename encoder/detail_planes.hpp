#pragma once

#include <cstdint>
#include <vector>

#include "coding/detail_code.hpp"
#include "coding/masked_wavelet.hpp"
#include "model/term_basis.hpp"

namespace mien::encoder {

/// One map on its way to bytes: coefficients in the trained basis, channels decorrelated, wavelet transformed.
class DetailPlanes {
public:
    /// mask_rank[i]: where texel i of the domain stands among the mask's texels.
    DetailPlanes(model::PolynomialMap map, const model::DomainMap& domain, const std::vector<Triangle>& marker_triangles, const model::TermFactors& factors,
                 const coding::MaskedWavelet& wavelet, const std::vector<std::uint32_t>& mask_rank);

    /// RMS error per texel that a step leaves.
    double error(float step) const;
    /// The largest step whose error is at most `rms`.
    float step_for(double rms) const;
    /// The largest magnitude in steps.
    double largest(float step) const;

    struct Coded {
        coding::MapHead head;
        std::vector<coding::MapStage> stages;
    };
    Coded code(float step, int stages) const;

private:
    const coding::MaskedWavelet& wavelet_;
    int channels_, order_, planes_;
    std::array<std::int16_t, 9> rotation_{};
    std::vector<float> coefficients_;  // [plane][coefficient]
};

}  // namespace mien::encoder
