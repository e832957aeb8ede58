#include "core/picture_measures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"

namespace mien {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;
constexpr int kRowsPerTask = 32;

using Taps = std::array<float, 2 * kRadius + 1>;
Taps gaussian() {
    Taps taps;
    double sum = 0;
    for (int i = -kRadius; i <= kRadius; ++i) sum += std::exp(-i * i / (2 * kSigma * kSigma));
    for (int i = -kRadius; i <= kRadius; ++i)
        taps[i + kRadius] = float(std::exp(-i * i / (2 * kSigma * kSigma)) / sum);
    return taps;
}

void luma_row(const Image& image, int y, float* out) {
    const std::uint8_t* p = image.at(0, y);
    for (int x = 0; x < image.width; ++x, p += image.channels)
        out[x] = image.channels < 3 ? p[0] : 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
}

/// The window's sums over rows y - 5 .. y + 5 of one map, for a row of texels. `rows` gives row y or null
/// outside.
template <class Row>
void filter_row(int width, int y, const Row& row, std::vector<float>& padded, float* out) {
    static const Taps taps = gaussian();
    std::fill(padded.begin(), padded.end(), 0.f);
    float* column = padded.data() + kRadius;
    for (int dy = -kRadius; dy <= kRadius; ++dy)
        if (const float* in = row(y + dy))
            for (int x = 0; x < width; ++x) column[x] += taps[dy + kRadius] * in[x];
    std::fill(out, out + width, 0.f);
    for (int dx = 0; dx <= 2 * kRadius; ++dx)
        for (int x = 0; x < width; ++x) out[x] += taps[dx] * padded[x + dx];
}

}  // namespace

PictureComparison::PictureComparison(int width, int height, std::vector<std::uint8_t> used)
    : width_(width), height_(height), used_(std::move(used)), weight_(std::size_t(width) * height) {
    if (used_.empty()) used_.assign(std::size_t(width) * height, 1);
    assert(used_.size() == std::size_t(width) * height);
    std::vector<float> mask(used_.size()), padded(std::size_t(width) + 2 * kRadius);
    for (std::size_t i = 0; i < mask.size(); ++i) {
        mask[i] = used_[i] ? 1.f : 0.f;
        used_count_ += used_[i] != 0;
    }
    const auto row = [&](int y) {
        return y < 0 || y >= height ? nullptr : mask.data() + std::size_t(y) * width;
    };
    for (int y = 0; y < height; ++y)
        filter_row(width, y, row, padded, weight_.data() + std::size_t(y) * width);
}

void PictureComparison::add(const Image& truth, const Image& received) {
    assert(truth.width == width_ && truth.height == height_ && received.width == width_ &&
           received.height == height_);
    constexpr double kC1 = (0.01 * 255) * (0.01 * 255), kC2 = (0.03 * 255) * (0.03 * 255);
    constexpr float kMiddle = 128;  // moments about the middle lose less to rounding
    const auto count = std::size_t((height_ + kRowsPerTask - 1) / kRowsPerTask);
    std::vector<double> errors(count), similarities(count);
    parallel_for(std::int64_t(count), [&](std::int64_t task) {
        const int y0 = int(task) * kRowsPerTask, y1 = std::min(height_, y0 + kRowsPerTask);
        const int first = std::max(0, y0 - kRadius), last = std::min(height_, y1 + kRadius);
        const std::size_t w = std::size_t(width_);
        std::vector<float> a(w), b(w), padded(w + 2 * kRadius);
        std::vector<float> maps[5], sums[5];  // a, b, aa, bb, ab
        for (auto& map : maps) map.resize(w * std::size_t(last - first));
        for (auto& sum : sums) sum.resize(w);
        double error = 0, similarity = 0;
        for (int y = first; y < last; ++y) {
            luma_row(truth, y, a.data());
            luma_row(received, y, b.data());
            const std::uint8_t* used = used_.data() + std::size_t(y) * w;
            const std::size_t at = std::size_t(y - first) * w;
            for (std::size_t x = 0; x < w; ++x) {
                if (!used[x]) continue;
                if (y >= y0 && y < y1) error += double(a[x] - b[x]) * double(a[x] - b[x]);
                const float p = a[x] - kMiddle, q = b[x] - kMiddle;
                maps[0][at + x] = p, maps[1][at + x] = q;
                maps[2][at + x] = p * p, maps[3][at + x] = q * q, maps[4][at + x] = p * q;
            }
        }
        for (int y = y0; y < y1; ++y) {
            for (int m = 0; m < 5; ++m)
                filter_row(
                    width_, y,
                    [&](int r) {
                        return r < first || r >= last ? nullptr : maps[m].data() + std::size_t(r - first) * w;
                    },
                    padded, sums[m].data());
            for (std::size_t x = 0; x < w; ++x) {
                const std::size_t at = std::size_t(y) * w + x;
                if (!used_[at]) continue;
                const double n = weight_[at], ma = sums[0][x] / n, mb = sums[1][x] / n;
                const double va = sums[2][x] / n - ma * ma, vb = sums[3][x] / n - mb * mb,
                             cov = sums[4][x] / n - ma * mb;
                const double la = ma + kMiddle, lb = mb + kMiddle;
                similarity +=
                    (2 * la * lb + kC1) * (2 * cov + kC2) / ((la * la + lb * lb + kC1) * (va + vb + kC2));
            }
        }
        errors[std::size_t(task)] = error;
        similarities[std::size_t(task)] = similarity;
    });
    for (std::size_t t = 0; t < count; ++t) squared_error_ += errors[t], ssim_sum_ += similarities[t];
    ++frames_;
}

double PictureComparison::psnr_y() const {
    const double n = double(used_count_) * double(frames_);
    if (n == 0) return std::numeric_limits<double>::quiet_NaN();
    if (squared_error_ == 0) return std::numeric_limits<double>::infinity();
    return 10 * std::log10(255.0 * 255.0 * n / squared_error_);
}

double PictureComparison::ssim() const {
    const double n = double(used_count_) * double(frames_);
    return n == 0 ? std::numeric_limits<double>::quiet_NaN() : ssim_sum_ / n;
}

double psnr_y(const Image& truth, const Image& received, const std::vector<std::uint8_t>& used) {
    PictureComparison comparison(truth.width, truth.height, used);
    comparison.add(truth, received);
    return comparison.psnr_y();
}

double ssim(const Image& truth, const Image& received, const std::vector<std::uint8_t>& used) {
    PictureComparison comparison(truth.width, truth.height, used);
    comparison.add(truth, received);
    return comparison.ssim();
}

}  // namespace mien
