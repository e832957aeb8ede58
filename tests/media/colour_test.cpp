#include <gtest/gtest.h>

#include "media/colour.hpp"

namespace mien::media {
namespace {

Image flat(int w, int h, int r, int g, int b) {
    Image image(w, h, 3);
    for (int i = 0; i < w * h; ++i)
        image.pixels[3 * i] = std::uint8_t(r), image.pixels[3 * i + 1] = std::uint8_t(g),
                         image.pixels[3 * i + 2] = std::uint8_t(b);
    return image;
}

TEST(Colour, PureColoursHaveTheirBt709Values) {
    // ITU-R BT.709-6, item 3.4 and 4.6: 8-bit quantisation.
    const struct {
        int rgb[3], ycc[3];
    } known[] = {{{255, 255, 255}, {235, 128, 128}}, {{0, 0, 0}, {16, 128, 128}},
                 {{255, 0, 0}, {63, 102, 240}},      {{0, 255, 0}, {173, 42, 26}},
                 {{0, 0, 255}, {32, 240, 118}},      {{255, 255, 0}, {219, 16, 138}}};
    for (const auto& k : known)
        for (const Chroma chroma : {Chroma::quarter, Chroma::full}) {
            YuvImage yuv(6, 4, chroma);
            to_yuv(flat(5, 3, k.rgb[0], k.rgb[1], k.rgb[2]), yuv);
            for (int p = 0; p < 3; ++p)
                for (const std::uint8_t v : yuv.planes[p])
                    EXPECT_EQ(v, k.ycc[p])
                        << "plane " << p << " of " << k.rgb[0] << ' ' << k.rgb[1] << ' ' << k.rgb[2];
        }
}

TEST(Colour, FlatPatchesComeBackWithinTwoLevels) {
    for (const Chroma chroma : {Chroma::quarter, Chroma::full})
        for (const bool full : {false, true})
            for (const auto matrix : {YuvView::Matrix::bt709, YuvView::Matrix::bt601})
                for (int r = 0; r < 256; r += 51)
                    for (int g = 0; g < 256; g += 51)
                        for (int b = 0; b < 256; b += 51) {
                            YuvImage yuv(4, 4, chroma, matrix, full);
                            to_yuv(flat(4, 4, r, g, b), yuv);
                            const Image back = to_rgb(yuv.view());
                            for (int i = 0; i < 16; ++i) {
                                EXPECT_NEAR(back.pixels[3 * i], r, 2);
                                EXPECT_NEAR(back.pixels[3 * i + 1], g, 2);
                                EXPECT_NEAR(back.pixels[3 * i + 2], b, 2);
                            }
                        }
}

TEST(Colour, ARampOfColourIsNotShiftedByItsChroma) {
    // Red and blue change linearly: with the right siting, linear interpolation of chroma brings every texel
    // back.
    Image ramp(64, 32, 3);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            ramp.at(x, y)[0] = std::uint8_t(40 + 3 * x), ramp.at(x, y)[1] = 120,
                       ramp.at(x, y)[2] = std::uint8_t(220 - 2 * x - 2 * y);
    YuvImage yuv(64, 32, Chroma::quarter);
    to_yuv(ramp, yuv);
    YuvView view = yuv.view();
    const auto worst = [&] {
        const Image back = to_rgb(view);
        int error = 0;
        for (int y = 2; y < 30; ++y)
            for (int x = 2; x < 61; ++x)
                for (int c = 0; c < 3; ++c)
                    error = std::max(error, std::abs(back.at(x, y)[c] - ramp.at(x, y)[c]));
        return error;
    };
    EXPECT_LE(worst(), 2);
    view.siting = YuvView::Siting::centre;  // the wrong one: half a texel off is 1.5 levels of red more
    EXPECT_GE(worst(), 3);
}

TEST(Colour, GreyStaysGreyAndAlphaIsIgnored) {
    Image grey(4, 2, 1), rgba(4, 2, 4);
    for (int i = 0; i < 8; ++i) {
        grey.pixels[i] = std::uint8_t(i * 31);
        for (int c = 0; c < 4; ++c) rgba.pixels[4 * i + c] = std::uint8_t(c < 3 ? i * 31 : 3 * i);
    }
    YuvImage a(4, 2, Chroma::quarter), b(4, 2, Chroma::quarter);
    to_yuv(grey, a);
    to_yuv(rgba, b);
    for (int p = 0; p < 3; ++p) EXPECT_EQ(a.planes[p], b.planes[p]);
    for (const std::uint8_t v : a.planes[1]) EXPECT_EQ(v, 128);
}

}  // namespace
}  // namespace mien::media
