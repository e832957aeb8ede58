#include "coding/coefficient_planes.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdlib>

#include "coding/integer_model.hpp"

namespace mien::coding {
namespace {

// Of the format (docs/format-detail.md).
constexpr int kLevels = 10;          // of the energy around a coefficient
constexpr int kFewLevels = 6;
constexpr int kBands = 28;           // three for each of the 9 levels of a 4096 map, and the low band
constexpr int kLimit = 400;
constexpr int kBitContexts = 3 * kLevels;

constexpr std::array<int, 7> kContexts = {
    kBands * kLevels,                                      // band, energy around
    CoefficientPlanes::kMaxPlanes * kLevels,               // plane, energy around
    kFewLevels * kLevels * 4,                              // parent, energy around, orientation
    kLevels * kLevels,                                     // other planes here, energy around
    CoefficientPlanes::kMaxPlanes * kBands,                // plane, band
    3 * 3 * 3 * 3 * 3 * 3,                                 // the four neighbours and two corners themselves
    kLevels * kLevels,                                     // other planes around, other planes here
};

int few(std::int32_t magnitude) { return magnitude < 2 ? int(magnitude) : 2; }

}  // namespace

CoefficientPlanes::CoefficientPlanes(const MaskedWavelet& wavelet, int planes)
    : wavelet_(wavelet), planes_(planes), values_(std::size_t(planes) * wavelet.size(), 0) {
    assert(planes > 0 && planes <= kMaxPlanes);
}

Bytes CoefficientPlanes::encode(const std::vector<std::int32_t>& truth, int below) {
    assert(truth.size() == values_.size());
    RangeEncoder coder;
    code(coder, &truth, below);
    return coder.finish();
}

bool CoefficientPlanes::decode(ByteView bytes) {
    RangeDecoder coder(bytes);
    code(coder, nullptr, 0);
    return coder.complete();
}

template <class Coder>
void CoefficientPlanes::code(Coder& coder, const std::vector<std::int32_t>* truth, int below) {
    const std::size_t n = wavelet_.size();
    const bool first = !started_;
    started_ = true;
    // Magnitudes in the new unit: twice what was known, until a coefficient is coded. A slot behind the last stands for all outside.
    std::vector<std::int32_t> magnitudes(std::size_t(planes_) * (n + 1), 0);
    std::vector<std::int32_t> total(n + 1, 0);  // over the planes
    for (int p = 0; p < planes_; ++p)
        for (std::size_t i = 0; i < n; ++i) {
            const std::int32_t m = 2 * std::abs(values_[std::size_t(p) * n + i]);
            magnitudes[std::size_t(p) * (n + 1) + i] = m;
            total[i] += m;
        }
    IntegerModel model(kContexts, kBands, 1, kLimit);
    std::array<AdaptiveBit, kBitContexts> bits{};
    for (const MaskedWavelet::Band& band : wavelet_.bands()) {
        std::vector<MaskedWavelet::Around> around = wavelet_.around(band);
        for (auto& place : around) {
            for (std::uint32_t& at : place.at) at = std::min(at, std::uint32_t(n));
            place.parent = std::min(place.parent, std::uint32_t(n));
        }
        const int band_context = band.orientation == 0 ? kBands - 1 : 3 * band.level + band.orientation - 1;
        for (int p = 0; p < planes_ && !coder.failed(); ++p) {
            std::int32_t* const own = magnitudes.data() + std::size_t(p) * (n + 1);
            for (std::uint32_t k = 0; k < band.count; ++k) {
                const std::uint32_t i = band.first + k;
                const MaskedWavelet::Around& near = around[k];
                std::int32_t side[4], corners = 0;
                for (int s = 0; s < 4; ++s) side[s] = own[near.at[s]];
                for (int s = 4; s < 8; ++s) corners += own[near.at[s]];
                const std::int32_t energy = 2 * (side[0] + side[1] + side[2] + side[3]) + corners;
                const int level = magnitude_level(std::uint32_t(energy), kLevels);
                std::int32_t& value = values_[std::size_t(p) * n + i];
                const std::int32_t before = own[i];
                if (before == 0) {
                    const std::int32_t here = total[i];
                    std::int32_t beside = 0;
                    for (int s = 0; s < 4; ++s) beside += total[near.at[s]];
                    const int here_level = magnitude_level(std::uint32_t(here), kLevels);
                    IntegerModel::Contexts contexts;
                    contexts.input = {band_context * kLevels + level,
                                      p * kLevels + level,
                                      (magnitude_level(std::uint32_t(own[near.parent]), kFewLevels) * kLevels + level) * 4 + band.orientation,
                                      here_level * kLevels + level,
                                      p * kBands + band_context,
                                      ((((few(side[0]) * 3 + few(side[1])) * 3 + few(side[2])) * 3 + few(side[3])) * 3 + few(own[near.at[4]])) * 3 + few(own[near.at[5]]),
                                      magnitude_level(std::uint32_t(beside), kLevels) * kLevels + here_level};
                    contexts.mixer = band_context;
                    std::int32_t coded = 0;
                    if (truth) {
                        const std::int32_t t = (*truth)[std::size_t(p) * n + i];
                        coded = t < 0 ? -(-t >> below) : t >> below;
                    }
                    model.code(coder, coded, contexts);
                    if (std::abs(coded) > (first ? kMaxValue : 1)) {
                        coder.fail();
                        coded = 0;
                    }
                    value = coded;
                } else {
                    int bit = 0;
                    if (truth) bit = std::abs((*truth)[std::size_t(p) * n + i]) >> below & 1;
                    bits[std::size_t(std::min(before / 2, 3) - 1) * kLevels + std::size_t(level)].code(coder, bit, kLimit);
                    value = value < 0 ? 2 * value - bit : 2 * value + bit;
                    if (std::abs(value) > kMaxValue) {
                        coder.fail();
                        value = 0;
                    }
                }
                own[i] = std::abs(value);
                total[i] += own[i] - before;
            }
        }
    }
}

}  // namespace mien::coding
