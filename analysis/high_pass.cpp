#include "analysis/high_pass.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace mien::analysis {
namespace {

/// Sums over 2 r + 1 entries along rows, turned by a diagonal: twice is both directions.
void box_transposed(const std::vector<float>& in, int width, int height, int r, std::vector<float>& out) {
    for (int y = 0; y < height; ++y) {
        const float* row = in.data() + std::size_t(y) * std::size_t(width);
        double sum = 0;
        for (int x = 0; x < std::min(r, width); ++x) sum += row[x];
        for (int x = 0; x < width; ++x) {
            if (x + r < width) sum += row[x + r];
            if (x - r - 1 >= 0) sum -= row[x - r - 1];
            out[std::size_t(x) * std::size_t(height) + std::size_t(y)] = float(sum / (2 * r + 1));
        }
    }
}

}  // namespace

FloatMap high_pass(const FloatMap& map, double sigma) {
    assert(map.channels == 1);
    const std::size_t n = map.values.size();
    std::vector<float> value(n), weight(n), turned(n);
    for (std::size_t i = 0; i < n; ++i) {
        weight[i] = std::isfinite(map.values[i]) ? 1.0f : 0.0f;
        value[i] = weight[i] > 0 ? map.values[i] : 0.0f;
    }
    // Three boxes of half width r have the variance of r (r + 1).
    const int r = std::max(1, int(std::lround((std::sqrt(1 + 4 * sigma * sigma) - 1) / 2)));
    for (std::vector<float>* field : {&value, &weight})
        for (int pass = 0; pass < 3; ++pass) {
            box_transposed(*field, map.width, map.height, r, turned);
            box_transposed(turned, map.height, map.width, r, *field);
        }
    FloatMap result = map;
    for (std::size_t i = 0; i < n; ++i)
        if (std::isfinite(map.values[i])) result.values[i] = map.values[i] - value[i] / std::max(weight[i], 1e-6f);
    return result;
}

}  // namespace mien::analysis
