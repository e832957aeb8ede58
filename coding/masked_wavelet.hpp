#pragma once

#include <cstdint>
#include <vector>

#include "coding/texel_mask.hpp"

namespace mien::coding {

/// The 9/7 wavelet over the set texels of a mask, as many coefficients as texels (shape-adaptive: Li and Li 2000): every run of texels in
/// a row, then in a column, is lifted with mirrored ends; a lone texel goes to the low band. Bases are near orthonormal, so an
/// error in the coefficients is about the same error in the texels. Samples and coefficients are floats: only their number and order
/// are part of the format, and those follow from the mask alone.
class MaskedWavelet {
public:
    explicit MaskedWavelet(const TexelMask& mask);

    static constexpr std::uint32_t kNone = 0xffffffffu;
    /// Coefficients first <= i < first + count, in rows.
    struct Band {
        int level;        ///< 0: finest
        int orientation;  ///< 0 low, 1 high along rows, 2 high along columns, 3 both
        std::uint32_t first, count;
    };
    const std::vector<Band>& bands() const { return bands_; }  ///< coarsest first
    std::uint32_t size() const { return std::uint32_t(texel_.size()); }

    /// Coefficients around each of a band's: left, right, up, down, then the four corners; kNone outside; and the one of the next coarser
    /// band of its orientation above it.
    struct Around {
        std::uint32_t at[8];
        std::uint32_t parent;
    };
    std::vector<Around> around(const Band& band) const;

    /// samples: of the set texels by rows; coefficients: band by band. size() each.
    void forward(const float* samples, float* coefficients) const;
    void inverse(const float* coefficients, float* samples) const;

private:
    struct Level {
        int width, height;                       // of the part of the plane that it splits
        std::vector<std::uint8_t> rows, columns; // which places hold samples before the step along rows, and before that along columns
    };
    struct Place {
        int x0, y0, width, height;  // of a band in the plane
    };
    Place place(const Band& band) const;
    std::uint32_t number(const Place& place, int x, int y) const;

    int width_, height_;
    std::vector<Level> levels_;                  // finest first
    std::vector<Band> bands_;
    std::vector<std::uint32_t> texel_;           // place in the plane of every set texel, by rows
    std::vector<std::uint32_t> coefficient_;     // place in the plane of every coefficient
    std::vector<std::uint32_t> number_;          // of the coefficient at a place
};

}  // namespace mien::coding
