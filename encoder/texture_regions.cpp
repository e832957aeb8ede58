#include "encoder/texture_regions.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace mien::encoder {

std::vector<media::VideoRegion> texture_regions(const std::vector<float>& weights, int width, int height) {
    assert(weights.size() == std::size_t(width) * height);
    constexpr int kBlock = 16;
    constexpr double kMostOffset = 12;
    std::vector<media::VideoRegion> regions;
    for (int top = 0; top < height; top += kBlock)
        for (int left = 0; left < width; left += kBlock) {
            const int right = std::min(left + kBlock, width), bottom = std::min(top + kBlock, height);
            double sum = 0;
            for (int y = top; y < bottom; ++y)
                for (int x = left; x < right; ++x) sum += weights[std::size_t(y) * width + x];
            const double mean = sum / (double(right - left) * (bottom - top));
            const double offset = mean > 0 ? std::clamp(-3 * std::log2(mean), -kMostOffset, kMostOffset) : kMostOffset;
            const double rounded = std::round(2 * offset) / 2;
            if (left > 0 && regions.back().qp_offset == rounded) regions.back().right = left + kBlock;
            else regions.push_back({left, top, left + kBlock, top + kBlock, rounded});
        }
    return regions;
}

}  // namespace mien::encoder
