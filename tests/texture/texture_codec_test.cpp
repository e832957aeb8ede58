#include <gtest/gtest.h>

#include "core/picture_measures.hpp"
#include "tests/texture/clips.hpp"

namespace mien {
namespace {

using namespace texture_test;

class EveryCodec : public testing::TestWithParam<std::string> {
protected:
    encoder::TextureOptions options(std::int64_t group_frames) const {
        encoder::TextureOptions options;
        options.codec = GetParam();
        options.group_frames = group_frames;
        if (GetParam() == "av1") options.speed = "10";
        if (GetParam() == "hevc" || GetParam() == "h264") options.speed = "veryfast";
        return options;
    }
};
INSTANTIATE_TEST_SUITE_P(Texture, EveryCodec, testing::ValuesIn(encoder::texture_codecs()), [](const auto& test) { return test.param; });

TEST_P(EveryCodec, ComesBackCloseToWhatWentInFrameForFrame) {
    const Clip clip = painted_clip(128, 96, 25);
    const auto encoded = encoder::encode_texture(clip, options(10));
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    ASSERT_EQ(encoded->groups.size(), 3u);
    EXPECT_EQ(encoded->groups[0].objects.size(), 10u);
    EXPECT_EQ(encoded->groups[2].objects.size(), 5u);
    auto decoder = decoder_of(*encoded);
    std::int64_t expected = 0;
    for (const auto& group : encoded->groups) {
        EXPECT_EQ(group.first_time, expected);
        const auto frames = decode_group(decoder, group);
        ASSERT_TRUE(frames.ok()) << frames.error().message;
        for (const auto& frame : *frames) {
            EXPECT_EQ(frame.frame, expected);
            const Image truth = *clip.texture->read(frame.frame), image = decoder::to_rgb(frame.picture);
            EXPECT_GT(psnr_y(truth, image), 34) << "frame " << frame.frame;
            if (frame.frame > 1) {
                EXPECT_GT(psnr_y(truth, image), 3 + psnr_y(*clip.texture->read(frame.frame - 1), image));
            }
            ++expected;
        }
    }
    EXPECT_EQ(expected, 25);
}

}  // namespace
}  // namespace mien
