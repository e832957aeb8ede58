#include "analysis/high_pass.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "core/wide.hpp"

namespace mien::analysis {
namespace {

/// sums += add - drop, out = sums * share, over n columns.
MIEN_LOOP slide_loop(const float* add, const float* drop, int n, double share, double* sums, float* out) {
    for (int x = 0; x < n; ++x) {
        sums[x] += double(add[x]) - double(drop[x]);
        out[x] = float(sums[x] * share);
    }
}
MIEN_WIDE(slide, (const float* add, const float* drop, int n, double share, double* sums, float* out), (add, drop, n, share, sums, out))

/// Means over 2 r + 1 entries down the columns; outside is 0.
void box_down(const std::vector<float>& in, int width, int height, int r, std::vector<float>& out) {
    const std::vector<float> nothing(std::size_t(width), 0.0f);
    const auto row = [&](int y) { return y < 0 || y >= height ? nothing.data() : in.data() + std::size_t(y) * std::size_t(width); };
    std::vector<double> sums(std::size_t(width), 0.0);
    for (int y = 0; y < std::min(r, height); ++y)
        for (int x = 0; x < width; ++x) sums[std::size_t(x)] += double(row(y)[x]);
    for (int y = 0; y < height; ++y) slide(row(y + r), row(y - r - 1), width, 1.0 / (2 * r + 1), sums.data(), out.data() + std::size_t(y) * std::size_t(width));
}

/// Rows become columns, tile by tile so that both stay in the cache.
void transpose(const std::vector<float>& in, int width, int height, std::vector<float>& out) {
    constexpr int tile = 16;
    for (int y0 = 0; y0 < height; y0 += tile)
        for (int x0 = 0; x0 < width; x0 += tile)
            for (int y = y0; y < std::min(y0 + tile, height); ++y)
                for (int x = x0; x < std::min(x0 + tile, width); ++x)
                    out[std::size_t(x) * std::size_t(height) + std::size_t(y)] = in[std::size_t(y) * std::size_t(width) + std::size_t(x)];
}

/// Three boxes one after another in both directions.
void blur(std::vector<float>& field, int width, int height, int r) {
    std::vector<float> other(field.size());
    for (int direction = 0; direction < 2; ++direction, std::swap(width, height)) {
        box_down(field, width, height, r, other);
        box_down(other, width, height, r, field);
        box_down(field, width, height, r, other);
        transpose(other, width, height, field);
    }
}

}  // namespace

FloatMap high_pass(const FloatMap& map, double sigma) {
    assert(map.channels == 1);
    const std::size_t n = map.values.size();
    std::vector<float> value(n), weight(n);
    for (std::size_t i = 0; i < n; ++i) {
        weight[i] = std::isfinite(map.values[i]) ? 1.0f : 0.0f;
        value[i] = weight[i] > 0 ? map.values[i] : 0.0f;
    }
    // Three boxes of half width r have the variance of r (r + 1).
    const int r = std::max(1, int(std::lround((std::sqrt(1 + 4 * sigma * sigma) - 1) / 2)));
    blur(value, map.width, map.height, r);
    blur(weight, map.width, map.height, r);
    FloatMap result = map;
    for (std::size_t i = 0; i < n; ++i)
        if (std::isfinite(map.values[i])) result.values[i] = map.values[i] - value[i] / std::max(weight[i], 1e-6f);
    return result;
}

}  // namespace mien::analysis
