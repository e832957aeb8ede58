#pragma once

#include <cstdint>
#include <vector>

#include "core/image.hpp"

namespace mien::bench {

/// PSNR-Y of the mean squared error over all counted pixels of all pictures, mean SSIM, and the worst single picture.
/// Pictures may each have counted pixels of their own.
class PictureScore {
public:
    /// counted: width * height of 0 or not 0. A picture in which nothing is counted has no say.
    void add(const Image& truth, const Image& received, const std::vector<std::uint8_t>& counted);

    std::int64_t pictures() const { return pictures_; }
    double psnr_y() const;  ///< dB, infinite when nothing differs
    double ssim() const;
    double worst_psnr_y() const;  ///< of one picture
    double last_psnr_y() const;   ///< of the latest picture

private:
    std::int64_t pictures_ = 0;
    double squared_error_ = 0, pixels_ = 0, ssim_sum_ = 0;
    double worst_ = 0, last_ = 0;  // mean squared error
};

}  // namespace mien::bench
