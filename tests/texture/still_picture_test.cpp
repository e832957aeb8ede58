#include <gtest/gtest.h>

#include <algorithm>

#include "core/texel_map.hpp"
#include "encoder/still_picture.hpp"

namespace mien {
namespace {

constexpr int kSide = 128;

/// Every texel is brightest in one frame of three, and neighbours in different ones.
class Twinkling : public TextureSource {
public:
    explicit Twinkling(std::int64_t frames) : frames_(frames) {}
    int width() const override { return kSide; }
    int height() const override { return kSide; }
    std::int64_t frames() const override { return frames_; }
    static std::uint8_t value(int x, int y, std::int64_t frame) { return std::uint8_t(40 + 10 * ((x + y + frame) % 3)); }
    Result<Image> read(std::int64_t frame) override {
        reads.push_back(frame);
        Image image(kSide, kSide, 3);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) std::fill_n(image.at(x, y), 3, value(x, y, frame));
        return image;
    }
    std::vector<std::int64_t> reads;

private:
    std::int64_t frames_;
};

/// Two squares side by side in the texture: skin, then teeth, four texels apart.
Mesh skin_and_teeth() {
    Mesh mesh;
    mesh.positions = Points::Zero(8, 3);
    for (int i = 0; i < 2; ++i) {
        const float left = i == 0 ? 16 : 64, right = i == 0 ? 60 : 100;
        const auto v = std::uint32_t(4 * i);
        for (const auto& [x, y] : {std::pair{left, 20.f}, {right, 20.f}, {right, 100.f}, {left, 100.f}}) mesh.texcoords.emplace_back(x / kSide, y / kSide);
        for (const Triangle& t : {Triangle{v, v + 1, v + 2}, Triangle{v, v + 2, v + 3}}) mesh.triangles.push_back(t), mesh.texcoord_triangles.push_back(t);
    }
    mesh.parts = {{"skin", Surface::skin, 0, 2}, {"teeth", Surface::teeth, 2, 2}};
    return mesh;
}

TEST(StillPicture, ShowsTeethAtTheirBrightestAndAllElseAsItIsFirst) {
    Clip clip;
    clip.neutral = skin_and_teeth();
    clip.texture = std::make_shared<Twinkling>(3);
    const auto picture = encoder::still_picture(clip);
    ASSERT_TRUE(picture.ok()) << picture.error().message;
    const TexelMap teeth = make_texel_map(*clip.neutral, kSide, kSide, 1u << int(Surface::teeth));
    int bright = 0, first = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const bool beside = x + 1 < kSide && !teeth.used(x, y) && teeth.used(x + 1, y);   // a filter reaches there
            const int shown = picture->at(x, y)[1];
            if (teeth.used(x, y) || beside) {
                ASSERT_EQ(shown, 60) << x << ", " << y;
                ++bright;
            } else if (x < 62) {
                ASSERT_EQ(shown, Twinkling::value(x, y, 0)) << x << ", " << y;
                ++first;
            }
        }
    EXPECT_GT(bright, 2000);
    EXPECT_GT(first, 5000);
}

TEST(StillPicture, ReadsAtMostAHundredFramesInAscendingOrder) {
    Clip clip;
    clip.neutral = skin_and_teeth();
    const auto texture = std::make_shared<Twinkling>(1234);
    clip.texture = texture;
    ASSERT_TRUE(encoder::still_picture(clip).ok());
    EXPECT_LE(texture->reads.size(), 101u);
    EXPECT_GE(texture->reads.size(), 90u);
    EXPECT_TRUE(std::is_sorted(texture->reads.begin(), texture->reads.end()));
    EXPECT_GT(texture->reads.back(), 1200);
}

}  // namespace
}  // namespace mien
