#include "core/picture_measures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "core/wide.hpp"

namespace mien {
namespace {

constexpr int kRadius = 5, kWindow = 2 * kRadius + 1;
constexpr double kSigma = 1.5;
constexpr int kRowsPerTask = 64;
constexpr float kMiddle = 128;  // moments about the middle lose less to rounding
constexpr float kC1 = float((0.01 * 255) * (0.01 * 255)), kC2 = float((0.03 * 255) * (0.03 * 255));

using Taps = std::array<float, kWindow>;
const Taps& gaussian() {
    static const Taps taps = [] {
        Taps t;
        double sum = 0;
        for (int i = -kRadius; i <= kRadius; ++i) sum += std::exp(-i * i / (2 * kSigma * kSigma));
        for (int i = -kRadius; i <= kRadius; ++i) t[i + kRadius] = float(std::exp(-i * i / (2 * kSigma * kSigma)) / sum);
        return t;
    }();
    return taps;
}

void luma_row(const Image& image, int y, float* out) {
    const std::uint8_t* p = image.at(0, y);
    if (image.channels < 3)
        for (int x = 0; x < image.width; ++x, p += image.channels) out[x] = p[0];
    else
        for (int x = 0; x < image.width; ++x, p += image.channels) out[x] = 0.2126f * float(p[0]) + 0.7152f * float(p[1]) + 0.0722f * float(p[2]);
}

MIEN_LOOP down_loop(const float* const* __restrict rows, const float* __restrict taps, int width, float* __restrict out) {
    const float *r0 = rows[0], *r1 = rows[1], *r2 = rows[2], *r3 = rows[3], *r4 = rows[4], *r5 = rows[5], *r6 = rows[6], *r7 = rows[7],
                *r8 = rows[8], *r9 = rows[9], *r10 = rows[10];
    // The window is its own mirror image.
    for (int x = 0; x < width; ++x)
        out[x] = taps[0] * (r0[x] + r10[x]) + taps[1] * (r1[x] + r9[x]) + taps[2] * (r2[x] + r8[x]) + taps[3] * (r3[x] + r7[x]) +
                 taps[4] * (r4[x] + r6[x]) + taps[5] * r5[x];
}
MIEN_WIDE(down, (const float* const* rows, const float* taps, int width, float* out), (rows, taps, width, out))

MIEN_LOOP across_loop(const float* __restrict in, const float* __restrict taps, int width, float* __restrict out) {
    for (int x = 0; x < width; ++x)
        out[x] = taps[0] * (in[x] + in[x + 10]) + taps[1] * (in[x + 1] + in[x + 9]) + taps[2] * (in[x + 2] + in[x + 8]) +
                 taps[3] * (in[x + 3] + in[x + 7]) + taps[4] * (in[x + 4] + in[x + 6]) + taps[5] * in[x + 5];
}
MIEN_WIDE(across, (const float* in, const float* taps, int width, float* out), (in, taps, width, out))

/// The window's sums of one map around a row of texels; `rows` are the 11 rows it reaches. `padded`: width + 10, of which
/// the 5 at either end stay 0.
void window_sums(const std::array<const float*, kWindow>& rows, int width, float* padded, float* out) {
    down(rows.data(), gaussian().data(), width, padded + kRadius);
    across(padded, gaussian().data(), width, out);
}

/// What one row of texels adds: their squared error, and the moments that SSIM asks for; 0 where they are not used.
MIEN_LOOP moments_loop(const float* __restrict truth, const float* __restrict received, const float* __restrict used, int width, float* __restrict a,
                       float* __restrict b, float* __restrict aa, float* __restrict bb, float* __restrict ab, float* __restrict error) {
    for (int x = 0; x < width; ++x) {
        const float p = (truth[x] - kMiddle) * used[x], q = (received[x] - kMiddle) * used[x], e = p - q;
        a[x] = p, b[x] = q;
        aa[x] = p * p, bb[x] = q * q, ab[x] = p * q;
        error[x] = e * e;
    }
}
MIEN_WIDE(moments,
          (const float* truth, const float* received, const float* used, int width, float* a, float* b, float* aa, float* bb, float* ab, float* error),
          (truth, received, used, width, a, b, aa, bb, ab, error))

/// `inverse`: 1 / the window's weight on used texels, 0 where a texel is not used.
MIEN_LOOP similarities_loop(const float* __restrict a, const float* __restrict b, const float* __restrict aa, const float* __restrict bb,
                            const float* __restrict ab, const float* __restrict inverse, const float* __restrict used, int width, float* __restrict out) {
    for (int x = 0; x < width; ++x) {
        const float n = inverse[x], ma = a[x] * n, mb = b[x] * n;
        const float va = aa[x] * n - ma * ma, vb = bb[x] * n - mb * mb, cov = ab[x] * n - ma * mb;
        const float la = ma + kMiddle, lb = mb + kMiddle;
        out[x] = used[x] * ((2 * la * lb + kC1) * (2 * cov + kC2)) / ((la * la + lb * lb + kC1) * (va + vb + kC2));
    }
}
MIEN_WIDE(similarities,
          (const float* a, const float* b, const float* aa, const float* bb, const float* ab, const float* inverse, const float* used, int width, float* out),
          (a, b, aa, bb, ab, inverse, used, width, out))

/// In double, and in four chains so that no addition waits for the one before it.
double sum_of(const std::vector<float>& values) {
    double sums[4] = {};
    for (std::size_t i = 0; i < values.size(); ++i) sums[i % 4] += double(values[i]);
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace

PictureComparison::PictureComparison(int width, int height, std::vector<std::uint8_t> used)
    : width_(width), height_(height), used_(std::size_t(width) * height, 1), inverse_weight_(used_.size()) {
    assert(used.empty() || used.size() == used_.size());
    for (std::size_t i = 0; i < used.size(); ++i) used_[i] = used[i] ? 1.f : 0.f;
    for (const float u : used_) used_count_ += u != 0;
    const auto w = std::size_t(width);
    std::vector<float> padded(w + 2 * kRadius);
    const std::vector<float> outside(w);
    for (int y = 0; y < height; ++y) {
        std::array<const float*, kWindow> rows;
        for (int i = 0; i < kWindow; ++i) {
            const int r = y + i - kRadius;
            rows[std::size_t(i)] = r < 0 || r >= height ? outside.data() : used_.data() + std::size_t(r) * w;
        }
        const std::size_t at = std::size_t(y) * w;
        window_sums(rows, width, padded.data(), inverse_weight_.data() + at);
        for (std::size_t i = at; i < at + w; ++i) inverse_weight_[i] = used_[i] != 0 ? 1 / inverse_weight_[i] : 0;
    }
}

void PictureComparison::add(const Image& truth, const Image& received) {
    assert(truth.width == width_ && truth.height == height_ && received.width == width_ &&
           received.height == height_);
    const auto count = std::size_t((height_ + kRowsPerTask - 1) / kRowsPerTask);
    std::vector<double> errors(count), similarity(count);
    parallel_for(std::int64_t(count), [&](std::int64_t task) {
        const int y0 = int(task) * kRowsPerTask, y1 = std::min(height_, y0 + kRowsPerTask);
        const int first = std::max(0, y0 - kRadius), last = std::min(height_, y1 + kRadius);
        const std::size_t w = std::size_t(width_);
        const std::vector<float> outside(w);
        std::vector<float> luma_a(w), luma_b(w), row(w), padded(w + 2 * kRadius);
        std::array<std::vector<float>, 5> maps, sums;  // a, b, aa, bb, ab
        for (auto& map : maps) map.resize(w * std::size_t(last - first));
        for (auto& sum : sums) sum.resize(w);
        double error = 0, alike = 0;
        for (int y = first; y < last; ++y) {
            luma_row(truth, y, luma_a.data());
            luma_row(received, y, luma_b.data());
            const std::size_t at = std::size_t(y - first) * w;
            moments(luma_a.data(), luma_b.data(), used_.data() + std::size_t(y) * w, width_, maps[0].data() + at, maps[1].data() + at,
                    maps[2].data() + at, maps[3].data() + at, maps[4].data() + at, row.data());
            if (y >= y0 && y < y1) error += sum_of(row);
        }
        for (int y = y0; y < y1; ++y) {
            for (std::size_t m = 0; m < maps.size(); ++m) {
                std::array<const float*, kWindow> rows;
                for (int i = 0; i < kWindow; ++i) {
                    const int r = y + i - kRadius;
                    rows[std::size_t(i)] = r < first || r >= last ? outside.data() : maps[m].data() + std::size_t(r - first) * w;
                }
                window_sums(rows, width_, padded.data(), sums[m].data());
            }
            const std::size_t at = std::size_t(y) * w;
            similarities(sums[0].data(), sums[1].data(), sums[2].data(), sums[3].data(), sums[4].data(), inverse_weight_.data() + at,
                         used_.data() + at, width_, row.data());
            alike += sum_of(row);
        }
        errors[std::size_t(task)] = error;
        similarity[std::size_t(task)] = alike;
    });
    for (std::size_t t = 0; t < count; ++t) squared_error_ += errors[t], ssim_sum_ += similarity[t];
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
