#pragma once

#include <cstdint>
#include <vector>

#include "coding/masked_wavelet.hpp"
#include "core/hash.hpp"

namespace mien::coding {

/// Quantised wavelet coefficients of several maps over one mask, coded bit plane by bit plane: stage 0 holds all magnitudes without
/// their lowest stages - 1 bits, every further stage one more bit of each. A coefficient's chances are learnt from what is known of those around
/// it, of its parent and of the other planes at its place. docs/format-detail.md gives the bytes.
class CoefficientPlanes {
public:
    CoefficientPlanes(const MaskedWavelet& wavelet, int planes);

    static constexpr int kMaxPlanes = 30;            // three channels of ten terms
    static constexpr std::int32_t kMaxValue = 1 << 20;

    int planes() const { return planes_; }
    /// Values of a plane as far as they are known: in units of the last stage that was coded.
    const std::int32_t* plane(int p) const { return values_.data() + std::size_t(p) * wavelet_.size(); }

    /// Codes the next stage of `truth` ([plane][coefficient], magnitudes at most kMaxValue), of which `below` further bits follow later.
    Bytes encode(const std::vector<std::int32_t>& truth, int below);
    /// Takes the next stage; false when its bytes are damaged.
    bool decode(ByteView bytes);

private:
    template <class Coder>
    void code(Coder& coder, const std::vector<std::int32_t>* truth, int below);

    const MaskedWavelet& wavelet_;
    int planes_;
    bool started_ = false;
    std::vector<std::int32_t> values_;  // [plane][coefficient]
};

}  // namespace mien::coding
