#include <gtest/gtest.h>

#include "core/parallel.hpp"
#include "encoder/texture_fill.hpp"
#include "tests/texture/clips.hpp"

namespace mien {
namespace {

using encoder::TextureFill;

/// A disc with a hole: gaps inside and outside.
std::vector<std::uint8_t> ring(int w, int h) {
    std::vector<std::uint8_t> used(std::size_t(w) * h);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            const double r = std::hypot(x - w / 2.0, y - h / 2.0) / h;
            used[std::size_t(y) * w + x] = r < 0.4 && r > 0.1;
        }
    return used;
}

TEST(TextureFill, LeavesTheChartsAloneAndGapsHoldNothingOfTheirOwn) {
    const auto used = ring(101, 67);
    TextureFill fill(101, 67, used);
    const Image painted = texture_test::PaintedTexture(101, 67, 1).paint(0);
    Image a = painted, b = painted;
    for (std::size_t i = 0; i < used.size(); ++i)
        if (!used[i])
            for (int c = 0; c < 3; ++c) a.pixels[3 * i + c] = 0, b.pixels[3 * i + c] = 255;
    fill.apply(a);
    fill.apply(b);
    EXPECT_EQ(a.pixels, b.pixels) << "what was in a gap shows in the fill";
    std::uint8_t low[3] = {255, 255, 255}, high[3] = {0, 0, 0};
    for (std::size_t i = 0; i < used.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (used[i]) {
                EXPECT_EQ(a.pixels[3 * i + c], painted.pixels[3 * i + c]);
                low[c] = std::min(low[c], a.pixels[3 * i + c]);
                high[c] = std::max(high[c], a.pixels[3 * i + c]);
            }
    for (std::size_t i = 0; i < used.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            EXPECT_GE(a.pixels[3 * i + c], low[c]);
            EXPECT_LE(a.pixels[3 * i + c], high[c]);
        }
}

TEST(TextureFill, ContinuesAFlatChartExactly) {
    const auto used = ring(64, 64);
    TextureFill fill(64, 64, used);
    Image image(64, 64, 3);
    for (std::size_t i = 0; i < used.size(); ++i)
        if (used[i]) image.pixels[3 * i] = 200, image.pixels[3 * i + 1] = 17, image.pixels[3 * i + 2] = 255;
    fill.apply(image);
    for (std::size_t i = 0; i < used.size(); ++i) {
        EXPECT_EQ(image.pixels[3 * i], 200);
        EXPECT_EQ(image.pixels[3 * i + 1], 17);
        EXPECT_EQ(image.pixels[3 * i + 2], 255);
    }
}

TEST(TextureFill, IsTheSameForAnyThreadCountAndHasNothingToDoWithoutGaps) {
    const int side = 300;
    const auto used = ring(side, side);
    TextureFill fill(side, side, used);
    Image one = texture_test::PaintedTexture(side, side, 1).paint(3), many = one;
    set_thread_count(1);
    fill.apply(one);
    set_thread_count(5);
    fill.apply(many);
    set_thread_count(0);
    EXPECT_EQ(one.pixels, many.pixels);
    EXPECT_TRUE(TextureFill(8, 8, std::vector<std::uint8_t>(64, 1)).empty());
    EXPECT_TRUE(TextureFill(8, 8, std::vector<std::uint8_t>(64, 0)).empty());
}

TEST(TextureFill, TakesTheMaskOverTheMeshAndTheMeshOverNothing) {
    Clip clip;
    EXPECT_EQ(encoder::used_texels(clip, 2, 2), (std::vector<std::uint8_t>{1, 1, 1, 1}));
    clip.neutral.emplace();
    clip.neutral->positions = Points::Zero(3, 3);
    clip.neutral->triangles = {{0, 1, 2}};
    clip.neutral->texcoords = {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)};  // the lower left half
    clip.neutral->texcoord_triangles = {{0, 1, 2}};
    EXPECT_EQ(encoder::used_texels(clip, 4, 4),
              (std::vector<std::uint8_t>{1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 1, 0, 1, 1, 1, 1}));
    clip.mask.emplace(2, 1, 1);
    clip.mask->pixels = {0, 9};
    EXPECT_EQ(encoder::used_texels(clip, 4, 2), (std::vector<std::uint8_t>{0, 0, 1, 1, 0, 0, 1, 1}));
}

}  // namespace
}  // namespace mien
