#include "bench/picture_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/picture_measures.hpp"

namespace mien::bench {
namespace {

double decibels(double mean_squared_error) {
    return mean_squared_error > 0 ? 10 * std::log10(255.0 * 255.0 / mean_squared_error) : std::numeric_limits<double>::infinity();
}

}  // namespace

void PictureScore::add(const Image& truth, const Image& received, const std::vector<std::uint8_t>& counted) {
    const double pixels = double(counted.size()) - double(std::count(counted.begin(), counted.end(), 0));
    if (pixels == 0) return;
    PictureComparison comparison(truth.width, truth.height, counted);
    comparison.add(truth, received);
    const double error = 255.0 * 255.0 / std::pow(10.0, comparison.psnr_y() / 10);
    squared_error_ += error * pixels;
    pixels_ += pixels;
    ssim_sum_ += comparison.ssim();
    worst_ = std::max(worst_, error);
    last_ = error;
    ++pictures_;
}

double PictureScore::psnr_y() const {
    return decibels(squared_error_ / pixels_);
}
double PictureScore::ssim() const {
    return ssim_sum_ / double(pictures_);
}
double PictureScore::last_psnr_y() const {
    return decibels(last_);
}
double PictureScore::worst_psnr_y() const {
    return decibels(worst_);
}

}  // namespace mien::bench
