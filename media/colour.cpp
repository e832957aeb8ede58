#include "media/colour.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"

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
    const int yr = fixed(k.r * luma_scale, kBits), yb = fixed(k.b * luma_scale, kBits);
    const int yg = fixed(luma_scale, kBits) - yr - yb;
    const double cb_unit = 0.5 / (1 - k.b), cr_unit = 0.5 / (1 - k.r);
    const ChromaWeights cb = chroma_weights(-k.r * cb_unit, -k.g * cb_unit, 0.5, chroma_scale, kBits);
    const ChromaWeights cr = chroma_weights(0.5, -k.g * cr_unit, -k.b * cr_unit, chroma_scale, kBits);
    const bool half = yuv.chroma_width < yuv.width;
    const int w = yuv.width;

    const auto convert_rows = [&](std::int64_t task) {
        SplitRow rows[2] = {SplitRow(w), SplitRow(w)};
        const int y_end = std::min(yuv.height, int(task + 1) * kRowsPerTask);
        for (int y = int(task) * kRowsPerTask; y < y_end; ++y) {
            SplitRow& row = rows[y & 1];
            row.load(picture, y, w);
            std::uint8_t* luma = yuv.planes[0].data() + std::size_t(y) * w;
            for (int x = 0; x < w; ++x)
                luma[x] = std::uint8_t(offset + ((yr * row.r[x + 1] + yg * row.g[x + 1] + yb * row.b[x + 1] +
                                                  (1 << (kBits - 1))) >>
                                                 kBits));
            if (half && !(y & 1)) continue;
            const std::size_t at = std::size_t(half ? y / 2 : y) * yuv.chroma_width;
            std::uint8_t *cb_out = yuv.planes[1].data() + at, *cr_out = yuv.planes[2].data() + at;
            const auto store = [&](int x, int r, int g, int b, int shift) {
                const int round = (128 << shift) + (1 << (shift - 1));
                cb_out[x] =
                    std::uint8_t(std::clamp((cb.r * r + cb.g * g + cb.b * b + round) >> shift, 0, 255));
                cr_out[x] =
                    std::uint8_t(std::clamp((cr.r * r + cr.g * g + cr.b * b + round) >> shift, 0, 255));
            };
            if (!half) {
                for (int x = 0; x < w; ++x) store(x, row.r[x + 1], row.g[x + 1], row.b[x + 1], kBits);
                continue;
            }
            const auto sum = [](const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b,
                                int x) {
                return a[x] + 2 * a[x + 1] + a[x + 2] + b[x] + 2 * b[x + 1] + b[x + 2];
            };
            for (int x = 0; x < w / 2; ++x)
                store(x, sum(rows[0].r, rows[1].r, 2 * x), sum(rows[0].g, rows[1].g, 2 * x),
                      sum(rows[0].b, rows[1].b, 2 * x), kBits + 3);
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
    constexpr int kBits = 16;  // of the luma factor; chroma carries four of them in its interpolation weights
    constexpr int kChromaBits = 12;
    const int offset = picture.full_range ? 0 : 16;
    const int ky = fixed(luma_scale, kBits);
    const int r_cr = fixed(2 * (1 - k.r) * chroma_scale, kChromaBits),
              b_cb = fixed(2 * (1 - k.b) * chroma_scale, kChromaBits);
    const int g_cb = fixed(2 * (1 - k.b) * k.b / k.g * chroma_scale, kChromaBits);
    const int g_cr = fixed(2 * (1 - k.r) * k.r / k.g * chroma_scale, kChromaBits);
    const bool half = picture.chroma_width < picture.width || picture.chroma_height < picture.height;
    const bool left = picture.siting != YuvView::Siting::centre,
               top = picture.siting == YuvView::Siting::top_left;
    const int w = picture.width, cw = picture.chroma_width, ch = picture.chroma_height;

    // Weights of 4 for luma place p between chroma samples: on the sample when sited with it, else 3 : 1.
    struct Tap {
        int first, second, weight;  // (4 - weight) * first + weight * second
    };
    const auto tap = [](int p, bool cosited, int count) -> Tap {
        const int i = p / 2;
        if (cosited) return {i, std::min(i + (p & 1), count - 1), (p & 1) ? 2 : 0};
        return {i, std::clamp(p & 1 ? i + 1 : i - 1, 0, count - 1), 1};
    };

    const auto convert_rows = [&](std::int64_t task) {
        std::vector<int> down, across[2];
        down.resize(std::size_t(cw));
        for (auto& row : across) row.resize(std::size_t(w));
        const int y_end = std::min(picture.height, int(task + 1) * kRowsPerTask);
        for (int y = int(task) * kRowsPerTask; y < y_end; ++y) {
            for (int p = 0; p < 2; ++p) {
                const std::uint8_t* plane = picture.planes[p + 1];
                const std::ptrdiff_t stride = picture.strides[p + 1];
                if (!half) {
                    for (int x = 0; x < w; ++x) across[p][x] = 16 * (plane[y * stride + x] - 128);
                    continue;
                }
                const Tap v = tap(y, top, ch);
                const std::uint8_t *a = plane + v.first * stride, *b = plane + v.second * stride;
                for (int x = 0; x < cw; ++x)
                    down[x] = (4 - v.weight) * (a[x] - 128) + v.weight * (b[x] - 128);
                for (int x = 0; x < w; ++x) {
                    const Tap h = tap(x, left, cw);
                    across[p][x] = (4 - h.weight) * down[h.first] + h.weight * down[h.second];
                }
            }
            const std::uint8_t* luma = picture.planes[0] + y * std::ptrdiff_t(picture.strides[0]);
            std::uint8_t* out = image.at(0, y);
            const int *cb = across[0].data(), *cr = across[1].data();
            for (int x = 0; x < w; ++x) {
                const int base = ky * (luma[x] - offset) + (1 << (kBits - 1));
                out[3 * x] = std::uint8_t(std::clamp((base + r_cr * cr[x]) >> kBits, 0, 255));
                out[3 * x + 1] =
                    std::uint8_t(std::clamp((base - g_cb * cb[x] - g_cr * cr[x]) >> kBits, 0, 255));
                out[3 * x + 2] = std::uint8_t(std::clamp((base + b_cb * cb[x]) >> kBits, 0, 255));
            }
        }
    };
    parallel_for((picture.height + kRowsPerTask - 1) / kRowsPerTask, convert_rows);
    return image;
}

}  // namespace mien::media
