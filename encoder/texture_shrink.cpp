#include "encoder/texture_shrink.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

constexpr int kBlock = 8;
constexpr float kMostExcess = 255;  // 1 / w - 1 where the step would be sixteen times as large

using Block = std::array<float, kBlock * kBlock>;

/// Rows of the orthonormal cosine transform.
const Block& cosines() {
    static const Block rows = [] {
        Block all;
        for (int k = 0; k < kBlock; ++k)
            for (int n = 0; n < kBlock; ++n)
                all[std::size_t(k * kBlock + n)] =
                    float((k ? std::sqrt(2.0 / kBlock) : std::sqrt(1.0 / kBlock)) * std::cos(M_PI * (n + 0.5) * k / kBlock));
        return all;
    }();
    return rows;
}

/// out = a * b, or a^T * b, of 8 x 8 matrices, transposed.
template <bool transpose_a>
Block product_transposed(const Block& a, const Block& b) {
    Block out{};
    for (int i = 0; i < kBlock; ++i)
        for (int j = 0; j < kBlock; ++j) {
            float sum = 0;
            for (int k = 0; k < kBlock; ++k)
                sum += (transpose_a ? a[std::size_t(k * kBlock + i)] : a[std::size_t(i * kBlock + k)]) * b[std::size_t(k * kBlock + j)];
            out[std::size_t(j * kBlock + i)] = sum;
        }
    return out;
}

/// Shrinks what a block differs from the same block of the frame before; null: from its own mean.
void shrink(std::uint8_t* samples, const std::uint8_t* before, int stride, float threshold_squared) {
    Block was{}, block;
    for (int y = 0; y < kBlock; ++y)
        for (int x = 0; x < kBlock; ++x) {
            const std::size_t i = std::size_t(y * kBlock + x);
            if (before) was[i] = before[y * stride + x];
            block[i] = samples[y * stride + x] - was[i];
        }
    Block coefficients = product_transposed<false>(cosines(), product_transposed<false>(cosines(), block));
    for (std::size_t i = before ? 0 : 1; i < coefficients.size(); ++i) {
        const float squared = coefficients[i] * coefficients[i];
        coefficients[i] *= squared > threshold_squared ? 1 - threshold_squared / squared : 0;
    }
    block = product_transposed<true>(cosines(), product_transposed<true>(cosines(), coefficients));
    for (int y = 0; y < kBlock; ++y)
        for (int x = 0; x < kBlock; ++x) {
            const std::size_t i = std::size_t(y * kBlock + x);
            samples[y * stride + x] = std::uint8_t(std::lround(std::clamp(was[i] + block[i], 0.0f, 255.0f)));
        }
}

}  // namespace

TextureShrink::TextureShrink(const std::vector<float>& weights, int width, int height) {
    assert(weights.size() == std::size_t(width) * height);
    for (const bool is_chroma : {false, true}) {
        Plane& plane = is_chroma ? chroma_ : luma_;
        const int side = is_chroma ? 2 * kBlock : kBlock;  // in texels
        plane.across = width / side;
        plane.down = height / side;
        for (int by = 0; by < plane.down; ++by)
            for (int bx = 0; bx < plane.across; ++bx) {
                double sum = 0;
                for (int y = by * side; y < (by + 1) * side; ++y)
                    for (int x = bx * side; x < (bx + 1) * side; ++x) sum += weights[std::size_t(y) * width + x];
                const double mean = sum / (double(side) * side);
                plane.excess.push_back(float(std::clamp(1 / std::max(mean, 1e-9) - 1, 0.0, double(kMostExcess))));
            }
    }
}

void TextureShrink::apply(media::YuvImage& picture, double step, const media::YuvImage* before) const {
    for (int p = 0; p < 3; ++p) {
        const Plane& plane = p ? chroma_ : luma_;
        const int stride = p ? picture.chroma_width : picture.width;
        parallel_for(plane.down, [&](std::int64_t by) {
            for (int bx = 0; bx < plane.across; ++bx) {
                const float excess = plane.excess[std::size_t(by) * plane.across + bx];
                if (excess <= 0) continue;
                const std::size_t at = std::size_t(by) * kBlock * stride + bx * kBlock;
                shrink(picture.planes[p].data() + at, before ? before->planes[p].data() + at : nullptr, stride, float(step * step) * excess);
            }
        });
    }
}

}  // namespace mien::encoder
