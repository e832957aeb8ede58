#include "core/picture_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mien {
namespace {

Image grey(int w, int h, int value) {
    Image image(w, h, 1);
    for (auto& p : image.pixels) p = std::uint8_t(value);
    return image;
}

TEST(PictureMeasures, KnowAConstantOffset) {
    const Image a = grey(40, 30, 100), b = grey(40, 30, 110);
    EXPECT_NEAR(psnr_y(a, b), 10 * std::log10(255.0 * 255 / 100), 1e-9);
    // Without variance SSIM is its luminance term alone.
    const double c1 = 6.5025;
    EXPECT_NEAR(ssim(a, b), (2 * 100 * 110 + c1) / (100.0 * 100 + 110 * 110 + c1), 1e-5);
    EXPECT_TRUE(std::isinf(psnr_y(a, a)));
    EXPECT_NEAR(ssim(a, a), 1, 1e-6);
}

TEST(PictureMeasures, WeighColoursAsLuma) {
    Image a(16, 16, 3), b(16, 16, 3);
    for (int i = 0; i < 256; ++i) b.pixels[3 * i + 1] = 50;  // green alone
    EXPECT_NEAR(psnr_y(a, b), 20 * std::log10(255 / (0.7152 * 50)), 1e-4);
}

TEST(PictureMeasures, CountOnlyUsedTexels) {
    const Image a = grey(32, 32, 100);
    Image b = grey(32, 32, 103);
    std::vector<std::uint8_t> used(32 * 32);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            used[std::size_t(y) * 32 + x] = x < 9;
            if (x >= 9) *b.at(x, y) = std::uint8_t(x * y);  // whatever
        }
    EXPECT_NEAR(psnr_y(a, b, used), 20 * std::log10(255.0 / 3), 1e-6);
    EXPECT_NEAR(ssim(a, b, used), (2 * 100 * 103 + 6.5025) / (100.0 * 100 + 103 * 103 + 6.5025), 1e-5);
}

TEST(PictureMeasures, InvertedTextureHasNegativeSimilarity) {
    Image a = grey(64, 64, 0), b = a;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            *a.at(x, y) = (x + y) % 2 ? 178 : 78;
            *b.at(x, y) = (x + y) % 2 ? 78 : 178;
        }
    // Equal means and variances 50^2, covariance -50^2, up to the window's small imbalance.
    const double c2 = 58.5225, v = 2500;
    EXPECT_NEAR(ssim(a, b), (-2 * v + c2) / (2 * v + c2), 0.01);
}

TEST(PictureMeasures, PoolErrorsOverFrames) {
    PictureComparison comparison(8, 8);
    EXPECT_TRUE(std::isnan(comparison.psnr_y()));
    comparison.add(grey(8, 8, 50), grey(8, 8, 50));
    comparison.add(grey(8, 8, 50), grey(8, 8, 54));
    EXPECT_EQ(comparison.frames(), 2);
    EXPECT_NEAR(comparison.psnr_y(), 10 * std::log10(255.0 * 255 / 8), 1e-9);
}

}  // namespace
}  // namespace mien
