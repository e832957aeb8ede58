#include "render/edge_smoothing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/parallel.hpp"
#include "core/wide.hpp"

namespace mien::render {
namespace {

constexpr int kRowsPerTask = 32;
// Luma of a pixel is 0 .. 4080, the sum over 2 x 2 of them 0 .. 16320.
constexpr int kWhite = 4 * 4080;
constexpr int kLeastContrast = int(0.018 * kWhite);   // and a sixteenth of the brightest: means of 2 x 2 show half the contrast of pixels
constexpr float kReach = 4;                           // pixels along an edge, to each side

MIEN_LOOP luma_row_loop(const std::uint8_t* __restrict rgba, int width, std::uint16_t* __restrict out) {
    for (int x = 0; x < width; ++x) out[x] = std::uint16_t((77 * rgba[4 * x] + 150 * rgba[4 * x + 1] + 29 * rgba[4 * x + 2]) >> 4);
}
MIEN_WIDE(luma_row, (const std::uint8_t* rgba, int width, std::uint16_t* out), (rgba, width, out))

/// Sums over 2 x 2 pixels; out[x] is the one of columns x and x + 1.
MIEN_LOOP block_row_loop(const std::uint16_t* __restrict a, const std::uint16_t* __restrict b, int width, std::uint16_t* __restrict out) {
    for (int x = 0; x < width; ++x) out[x] = std::uint16_t(a[x] + a[x + 1] + b[x] + b[x + 1]);
}
MIEN_WIDE(block_row, (const std::uint16_t* a, const std::uint16_t* b, int width, std::uint16_t* out), (a, b, width, out))

/// Which pixels have an edge, from the blocks at their four corners; `below[x]` and `below[x + 1]` are of pixel x.
MIEN_LOOP edge_row_loop(const std::uint16_t* __restrict luma, const std::uint16_t* __restrict below, const std::uint16_t* __restrict above, int width,
                        std::uint16_t* __restrict edge) {
    for (int x = 0; x < width; ++x) {
        const int m = 4 * luma[x];
        const int low = std::min(m, std::min(std::min<int>(below[x], below[x + 1]), std::min<int>(above[x], above[x + 1])));
        const int high = std::max(m, std::max(std::max<int>(below[x], below[x + 1]), std::max<int>(above[x], above[x + 1])));
        edge[x] = high - low >= std::max(kLeastContrast, high >> 4);
    }
}
MIEN_WIDE(edge_row, (const std::uint16_t* luma, const std::uint16_t* below, const std::uint16_t* above, int width, std::uint16_t* edge),
          (luma, below, above, width, edge))

using Colour = std::array<float, 3>;

/// Bilinear; beyond the picture its border goes on. The middle of pixel (x, y) is at (x, y).
Colour sample(const std::uint8_t* rgba, int width, int height, float x, float y) {
    const float left = std::floor(x), low = std::floor(y), u = x - left, v = y - low;
    const int x0 = std::clamp(int(left), 0, width - 1), x1 = std::clamp(int(left) + 1, 0, width - 1);
    const int y0 = std::clamp(int(low), 0, height - 1), y1 = std::clamp(int(low) + 1, 0, height - 1);
    const auto at = [&](int px, int py) { return rgba + 4 * (std::size_t(py) * std::size_t(width) + std::size_t(px)); };
    const std::uint8_t *a = at(x0, y0), *b = at(x1, y0), *c = at(x0, y1), *d = at(x1, y1);
    Colour colour;
    for (std::size_t i = 0; i < 3; ++i) {
        const float below = float(a[i]) + u * (float(b[i]) - float(a[i])), above = float(c[i]) + u * (float(d[i]) - float(c[i]));
        colour[i] = below + v * (above - below);
    }
    return colour;
}

Colour mean(const Colour& a, const Colour& b) { return {0.5f * (a[0] + b[0]), 0.5f * (a[1] + b[1]), 0.5f * (a[2] + b[2])}; }

/// Sums over 2 x 2 pixels around a pixel and itself, of 1.
struct Corners {
    float middle, nw, ne, sw, se;
};

void blend(const std::uint8_t* drawn, int width, int height, int x, int y, const Corners& c, std::uint8_t* out) {
    const float low = std::min({c.middle, c.nw, c.ne, c.sw, c.se}), high = std::max({c.middle, c.nw, c.ne, c.sw, c.se});
    // The gradient is (right - left, up - down); turned by a quarter it lies along the edge. 1 pixel where it runs with the grid.
    float dx = -((c.nw + c.ne) - (c.sw + c.se)), dy = (c.ne + c.se) - (c.nw + c.sw);
    const float steepness = 1 / (std::min(std::abs(dx), std::abs(dy)) + 1.0f / 128);
    dx = std::clamp(dx * steepness, -kReach, kReach);
    dy = std::clamp(dy * steepness, -kReach, kReach);
    const auto along = [&](float share) { return sample(drawn, width, height, float(x) + dx * share, float(y) + dy * share); };
    const Colour near = mean(along(1.0f / 3 - 0.5f), along(2.0f / 3 - 0.5f));
    const Colour wide = mean(near, mean(along(-0.5f), along(0.5f)));
    const float luma = (0.299f * wide[0] + 0.587f * wide[1] + 0.114f * wide[2]) / 255;
    const Colour& chosen = luma < low || luma > high ? near : wide;
    for (std::size_t i = 0; i < 3; ++i) out[i] = std::uint8_t(chosen[i] + 0.5f);
}

}  // namespace

void smooth_edges(const std::uint8_t* drawn, int width, int height, const Eigen::AlignedBox2i& pixels, std::uint8_t* smoothed) {
    const std::size_t stride = 4 * std::size_t(width);
    std::memcpy(smoothed, drawn, stride * std::size_t(height));
    const Eigen::AlignedBox2i box = pixels.intersection({Eigen::Vector2i::Zero(), Eigen::Vector2i(width, height)});
    if (box.isEmpty()) return;
    const int first = box.min().y(), end = box.max().y();
    parallel_for((end - first + kRowsPerTask - 1) / kRowsPerTask, [&](std::int64_t task) {
        const int y0 = first + int(task) * kRowsPerTask, y1 = std::min(end, y0 + kRowsPerTask);
        const auto w = std::size_t(width);
        // One column more at either side repeats the border, as one row more above and below does.
        std::vector<std::uint16_t> lumas[2] = {std::vector<std::uint16_t>(w + 2), std::vector<std::uint16_t>(w + 2)};
        std::vector<std::uint16_t> blocks[2] = {std::vector<std::uint16_t>(w + 1), std::vector<std::uint16_t>(w + 1)}, edge(w);
        const auto load = [&](int y, std::vector<std::uint16_t>& luma) {
            luma_row(drawn + stride * std::size_t(std::clamp(y, 0, height - 1)), width, luma.data() + 1);
            luma[0] = luma[1];
            luma[w + 1] = luma[w];
        };
        load(y0 - 1, lumas[(y0 + 1) & 1]);
        load(y0, lumas[y0 & 1]);
        block_row(lumas[0].data(), lumas[1].data(), width + 1, blocks[y0 & 1].data());
        std::vector<std::uint16_t> luma;
        for (int y = y0; y < y1; ++y) {
            luma = lumas[y & 1];
            load(y + 1, lumas[(y + 1) & 1]);
            const std::vector<std::uint16_t>&below = blocks[y & 1], &above = blocks[(y + 1) & 1];
            block_row(lumas[0].data(), lumas[1].data(), width + 1, blocks[(y + 1) & 1].data());
            edge_row(luma.data() + 1, below.data(), above.data(), width, edge.data());
            for (int x = box.min().x(); x < box.max().x(); ++x) {
                const auto i = std::size_t(x);
                if (!edge[i]) continue;
                const auto part = [](int sum) { return float(sum) / float(kWhite); };
                const Corners corners{part(4 * luma[i + 1]), part(above[i]), part(above[i + 1]), part(below[i]), part(below[i + 1])};
                blend(drawn, width, height, x, y, corners, smoothed + stride * std::size_t(y) + 4 * i);
            }
        }
    });
}

}  // namespace mien::render
