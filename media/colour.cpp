#include "media/colour.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "core/wide.hpp"

namespace mien::media {
namespace {

constexpr int kRowsPerTask = 32;

struct Luma {
    double r, g, b;
};
constexpr Luma luma_of(YuvView::Matrix matrix) {
    return matrix == YuvView::Matrix::bt709 ? Luma{0.2126, 0.7152, 0.0722} : Luma{0.299, 0.587, 0.114};
}
int fixed(double value, int bits) {
    return int(std::lround(std::ldexp(value, bits)));
}

/// Rows of R, G and B apart, `width` long with the last column repeated, and one repeated column before the
/// first.
struct SplitRow {
    std::vector<std::uint8_t> r, g, b;
    explicit SplitRow(int width) : r(width + 2), g(width + 2), b(width + 2) {}

    void load(const Image& picture, int y, int width) {
        const std::uint8_t* p = picture.at(0, std::min(y, picture.height - 1));
        const int step = picture.channels, g_at = step >= 3 ? 1 : 0, b_at = step >= 3 ? 2 : 0;
        for (int x = 0; x < picture.width; ++x, p += step)
            r[x + 1] = p[0], g[x + 1] = p[g_at], b[x + 1] = p[b_at];
        for (auto* row : {&r, &g, &b}) {
            (*row)[0] = (*row)[1];
            std::fill(row->begin() + picture.width + 1, row->begin() + width + 2, (*row)[picture.width]);
        }
    }
};

/// Signed weights of one chroma plane, fixed point, that sum to exactly zero so that grey stays grey.
struct ChromaWeights {
    int r, g, b;
};
ChromaWeights chroma_weights(double r, double g, double b, double scale, int bits) {
    ChromaWeights w{fixed(r * scale, bits), fixed(g * scale, bits), fixed(b * scale, bits)};
    w.g = -w.r - w.b;
    return w;
}

/// out = (r, g, b weighed, plus `round`) >> shift, cut to a byte.
template <class Value>
MIEN_LOOP weigh_loop(const Value* __restrict r, const Value* __restrict g, const Value* __restrict b, ChromaWeights k, int round, int shift, int width,
                     std::uint8_t* __restrict out) {
    for (int x = 0; x < width; ++x) out[x] = std::uint8_t(std::clamp((k.r * r[x] + k.g * g[x] + k.b * b[x] + round) >> shift, 0, 255));
}
MIEN_LOOP weigh_bytes_loop(const std::uint8_t* r, const std::uint8_t* g, const std::uint8_t* b, ChromaWeights k, int round, int shift, int width,
                           std::uint8_t* out) {
    weigh_loop(r, g, b, k, round, shift, width, out);
}
MIEN_WIDE(weigh_bytes,
          (const std::uint8_t* r, const std::uint8_t* g, const std::uint8_t* b, ChromaWeights k, int round, int shift, int width, std::uint8_t* out),
          (r, g, b, k, round, shift, width, out))
MIEN_LOOP weigh_sums_loop(const std::uint16_t* r, const std::uint16_t* g, const std::uint16_t* b, ChromaWeights k, int round, int shift, int width,
                          std::uint8_t* out) {
    weigh_loop(r, g, b, k, round, shift, width, out);
}
MIEN_WIDE(weigh_sums,
          (const std::uint16_t* r, const std::uint16_t* g, const std::uint16_t* b, ChromaWeights k, int round, int shift, int width, std::uint8_t* out),
          (r, g, b, k, round, shift, width, out))

/// Sums of 2 rows x 3 columns with the middle column twice, around every second column: 8 times the mean of a block whose
/// chroma sits at its left edge. `a` and `b` begin one column early.
MIEN_LOOP halve_loop(const std::uint8_t* __restrict a, const std::uint8_t* __restrict b, int width, std::uint16_t* __restrict out) {
    for (int x = 0; x < width; ++x)
        out[x] = std::uint16_t(a[2 * x] + b[2 * x] + 2 * (a[2 * x + 1] + b[2 * x + 1]) + a[2 * x + 2] + b[2 * x + 2]);
}
MIEN_WIDE(halve, (const std::uint8_t* a, const std::uint8_t* b, int width, std::uint16_t* out), (a, b, width, out))

/// Chroma of a row of luma, times 4, from the two rows of samples above and below it.
MIEN_LOOP mix_rows_loop(const std::uint8_t* __restrict a, const std::uint8_t* __restrict b, int weight, int width, int* __restrict out) {
    for (int x = 0; x < width; ++x) out[x] = (4 - weight) * (a[x] - 128) + weight * (b[x] - 128);
}
MIEN_WIDE(mix_rows, (const std::uint8_t* a, const std::uint8_t* b, int weight, int width, int* out), (a, b, weight, width, out))

/// The same across: `chroma[-1]` and `chroma[width]` repeat the samples at the ends. `left`: samples sit on even columns of
/// luma, else between two.
MIEN_LOOP spread_loop(const int* __restrict chroma, bool left, int width, int* __restrict out) {
    if (left) {
        for (int i = 0; i < width; ++i) {
            out[2 * i] = 4 * chroma[i];
            out[2 * i + 1] = 2 * chroma[i] + 2 * chroma[i + 1];
        }
    } else {
        for (int i = 0; i < width; ++i) {
            out[2 * i] = 3 * chroma[i] + chroma[i - 1];
            out[2 * i + 1] = 3 * chroma[i] + chroma[i + 1];
        }
    }
}
MIEN_WIDE(spread, (const int* chroma, bool left, int width, int* out), (chroma, left, width, out))

/// Weights of luma (kBits of fraction) and of 16 times chroma.
struct RgbWeights {
    static constexpr int kBits = 16;
    int offset, luma, r_cr, g_cb, g_cr, b_cb;
};
MIEN_LOOP rgb_row_loop(const std::uint8_t* __restrict luma, const int* __restrict cb, const int* __restrict cr, RgbWeights k, int width,
                       std::uint8_t* __restrict r, std::uint8_t* __restrict g, std::uint8_t* __restrict b) {
    for (int x = 0; x < width; ++x) {
        const int base = k.luma * (luma[x] - k.offset) + (1 << (RgbWeights::kBits - 1));
        r[x] = std::uint8_t(std::clamp((base + k.r_cr * cr[x]) >> RgbWeights::kBits, 0, 255));
        g[x] = std::uint8_t(std::clamp((base - k.g_cb * cb[x] - k.g_cr * cr[x]) >> RgbWeights::kBits, 0, 255));
        b[x] = std::uint8_t(std::clamp((base + k.b_cb * cb[x]) >> RgbWeights::kBits, 0, 255));
    }
}
MIEN_WIDE(rgb_row,
          (const std::uint8_t* luma, const int* cb, const int* cr, RgbWeights k, int width, std::uint8_t* r, std::uint8_t* g, std::uint8_t* b),
          (luma, cb, cr, k, width, r, g, b))

}  // namespace

YuvImage::YuvImage(int w, int h, Chroma chroma, YuvView::Matrix m, bool full)
    : width(w),
      height(h),
      chroma_width(chroma == Chroma::quarter ? w / 2 : w),
      chroma_height(chroma == Chroma::quarter ? h / 2 : h),
      matrix(m),
      full_range(full) {
    assert(chroma == Chroma::full || (w % 2 == 0 && h % 2 == 0));
    planes[0].resize(std::size_t(w) * h);
    for (int p = 1; p < 3; ++p) planes[p].resize(std::size_t(chroma_width) * chroma_height);
}

YuvView YuvImage::view() const {
    YuvView view;
    view.width = width, view.height = height;
    view.chroma_width = chroma_width, view.chroma_height = chroma_height;
    for (int p = 0; p < 3; ++p) view.planes[p] = planes[p].data(), view.strides[p] = p ? chroma_width : width;
    view.matrix = matrix;
    view.full_range = full_range;
    return view;
}

void to_yuv(const Image& picture, YuvImage& yuv) {
    assert(picture.width > 0 && picture.height > 0 && picture.width <= yuv.width &&
           picture.height <= yuv.height);
    const Luma k = luma_of(yuv.matrix);
    const double luma_scale = yuv.full_range ? 1 : 219.0 / 255,
                 chroma_scale = yuv.full_range ? 1 : 224.0 / 255;
    constexpr int kBits = 16;
    const int offset = yuv.full_range ? 0 : 16;
    ChromaWeights luma{fixed(k.r * luma_scale, kBits), 0, fixed(k.b * luma_scale, kBits)};
    luma.g = fixed(luma_scale, kBits) - luma.r - luma.b;
    const double cb_unit = 0.5 / (1 - k.b), cr_unit = 0.5 / (1 - k.r);
    const ChromaWeights cb = chroma_weights(-k.r * cb_unit, -k.g * cb_unit, 0.5, chroma_scale, kBits);
    const ChromaWeights cr = chroma_weights(0.5, -k.g * cr_unit, -k.b * cr_unit, chroma_scale, kBits);
    const bool half = yuv.chroma_width < yuv.width;
    const int w = yuv.width;
    const auto rounded = [](int middle, int bits) { return (middle << bits) + (1 << (bits - 1)); };

    const auto convert_rows = [&](std::int64_t task) {
        SplitRow rows[2] = {SplitRow(w), SplitRow(w)};
        std::vector<std::uint16_t> r, g, b;
        for (auto* sums : {&r, &g, &b}) sums->resize(std::size_t(w) / 2);
        const int y_end = std::min(yuv.height, int(task + 1) * kRowsPerTask);
        for (int y = int(task) * kRowsPerTask; y < y_end; ++y) {
            SplitRow& row = rows[y & 1];
            row.load(picture, y, w);
            weigh_bytes(row.r.data() + 1, row.g.data() + 1, row.b.data() + 1, luma, rounded(offset, kBits), kBits, w, yuv.planes[0].data() + std::size_t(y) * w);
            if (half && !(y & 1)) continue;
            const std::size_t at = std::size_t(half ? y / 2 : y) * yuv.chroma_width;
            std::uint8_t *cb_out = yuv.planes[1].data() + at, *cr_out = yuv.planes[2].data() + at;
            if (!half) {
                weigh_bytes(row.r.data() + 1, row.g.data() + 1, row.b.data() + 1, cb, rounded(128, kBits), kBits, w, cb_out);
                weigh_bytes(row.r.data() + 1, row.g.data() + 1, row.b.data() + 1, cr, rounded(128, kBits), kBits, w, cr_out);
                continue;
            }
            halve(rows[0].r.data(), rows[1].r.data(), w / 2, r.data());
            halve(rows[0].g.data(), rows[1].g.data(), w / 2, g.data());
            halve(rows[0].b.data(), rows[1].b.data(), w / 2, b.data());
            weigh_sums(r.data(), g.data(), b.data(), cb, rounded(128, kBits + 3), kBits + 3, w / 2, cb_out);
            weigh_sums(r.data(), g.data(), b.data(), cr, rounded(128, kBits + 3), kBits + 3, w / 2, cr_out);
        }
    };
    static_assert(kRowsPerTask % 2 == 0);
    parallel_for((yuv.height + kRowsPerTask - 1) / kRowsPerTask, convert_rows);
}

Image to_rgb(const YuvView& picture) {
    Image image(picture.width, picture.height, 3);
    const Luma k = luma_of(picture.matrix);
    const double luma_scale = picture.full_range ? 1 : 255.0 / 219,
                 chroma_scale = picture.full_range ? 1 : 255.0 / 224;
    constexpr int kChromaBits = 12;   // the other four are in the weights of its interpolation
    RgbWeights weights;
    weights.offset = picture.full_range ? 0 : 16;
    weights.luma = fixed(luma_scale, RgbWeights::kBits);
    weights.r_cr = fixed(2 * (1 - k.r) * chroma_scale, kChromaBits);
    weights.b_cb = fixed(2 * (1 - k.b) * chroma_scale, kChromaBits);
    weights.g_cb = fixed(2 * (1 - k.b) * k.b / k.g * chroma_scale, kChromaBits);
    weights.g_cr = fixed(2 * (1 - k.r) * k.r / k.g * chroma_scale, kChromaBits);
    const bool half = picture.chroma_width < picture.width || picture.chroma_height < picture.height;
    const bool left = picture.siting != YuvView::Siting::centre,
               top = picture.siting == YuvView::Siting::top_left;
    const int w = picture.width, cw = picture.chroma_width, ch = picture.chroma_height;

    const auto convert_rows = [&](std::int64_t task) {
        std::vector<int> between(std::size_t(cw) + 2), across[2];
        std::vector<std::uint8_t> r, g, b;
        for (auto& row : across) row.resize(std::size_t(std::max(w, 2 * cw)));
        for (auto* row : {&r, &g, &b}) row->resize(std::size_t(w));
        const int y_end = std::min(picture.height, int(task + 1) * kRowsPerTask);
        for (int y = int(task) * kRowsPerTask; y < y_end; ++y) {
            for (int p = 0; p < 2; ++p) {
                const std::uint8_t* plane = picture.planes[p + 1];
                const std::ptrdiff_t stride = picture.strides[p + 1];
                if (!half) {
                    for (int x = 0; x < w; ++x) across[p][std::size_t(x)] = 16 * (plane[y * stride + x] - 128);
                    continue;
                }
                // Weights of 4 for a row of luma between rows of chroma: on the row when sited with it, else 3 : 1.
                const int above = y / 2, other = std::clamp(top || (y & 1) ? above + 1 : above - 1, 0, ch - 1);
                mix_rows(plane + above * stride, plane + other * stride, !top ? 1 : (y & 1) ? 2 : 0, cw, between.data() + 1);
                between.front() = between[1];
                between.back() = between[std::size_t(cw)];
                spread(between.data() + 1, left, cw, across[p].data());
            }
            rgb_row(picture.planes[0] + y * std::ptrdiff_t(picture.strides[0]), across[0].data(), across[1].data(), weights, w, r.data(), g.data(), b.data());
            std::uint8_t* out = image.at(0, y);
            for (int x = 0; x < w; ++x, out += 3) out[0] = r[std::size_t(x)], out[1] = g[std::size_t(x)], out[2] = b[std::size_t(x)];
        }
    };
    parallel_for((picture.height + kRowsPerTask - 1) / kRowsPerTask, convert_rows);
    return image;
}

}  // namespace mien::media
