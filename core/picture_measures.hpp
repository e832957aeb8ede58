#pragma once

#include <cstdint>
#include <vector>

#include "core/image.hpp"

namespace mien {

/// How far received pictures are from the truth, inside the used texels, on luma (BT.709 weights on the
/// encoded RGB, not rounded, 0 .. 255; grey pictures are their own luma).
///
/// PSNR-Y is that of the mean squared error over all texels and frames, so one bad frame shows. SSIM (Wang et
/// al. 2004) has a Gaussian window of 11 x 11 with sigma 1.5, K1 = 0.01, K2 = 0.03, and is the mean over used
/// texels and frames; where the window reaches unused texels or leaves the picture, their weight goes to the
/// others, so that what a codec does outside the face never counts.
class PictureComparison {
public:
    /// used: width * height of 0 or not 0; empty: all.
    PictureComparison(int width, int height, std::vector<std::uint8_t> used = {});

    /// Both of the size above, with 1, 3 or 4 channels.
    void add(const Image& truth, const Image& received);

    std::int64_t frames() const { return frames_; }
    double psnr_y() const;  ///< dB; infinite when nothing differs; 0 frames: NaN
    double ssim() const;    ///< -1 .. 1; 0 frames: NaN

private:
    int width_, height_;
    std::vector<float> used_;            ///< 0 or 1
    std::vector<float> inverse_weight_;  ///< 1 / the window's weight on used texels, around each used texel
    std::int64_t used_count_ = 0;
    std::int64_t frames_ = 0;
    double squared_error_ = 0;  ///< sum over frames and used texels
    double ssim_sum_ = 0;
};

/// The same for one pair of pictures.
double psnr_y(const Image& truth, const Image& received, const std::vector<std::uint8_t>& used = {});
double ssim(const Image& truth, const Image& received, const std::vector<std::uint8_t>& used = {});

}  // namespace mien
