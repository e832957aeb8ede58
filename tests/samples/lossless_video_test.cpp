#include "media/lossless_video.hpp"

#include <gtest/gtest.h>

#include "media/video_reader.hpp"
#include "recordings.hpp"
#include "samples/noise.hpp"

namespace mien::media {
namespace {

TEST(LosslessVideo, KeepsEveryBitAndTheFrameRate) {
    const samples::TemporaryFolder folder;
    for (const auto& [width, height] : {std::pair{96, 80}, {33, 17}}) {
        std::vector<Image> pictures(5, Image(width, height, 3));
        samples::Random random(1);
        auto video = LosslessVideoWriter::open(folder / "a.mkv", width, height, make_rational(30000, 1001));
        ASSERT_TRUE(video.ok()) << video.error().message;
        for (Image& picture : pictures) {
            for (std::uint8_t& p : picture.pixels) p = std::uint8_t(random.bits());
            ASSERT_TRUE(video->write(picture).ok());
        }
        ASSERT_TRUE(video->finish().ok());
        auto reader = VideoReader::open(folder / "a.mkv");
        ASSERT_TRUE(reader.ok()) << reader.error().message;
        ASSERT_EQ((*reader)->frames(), 5);
        EXPECT_EQ((*reader)->frame_rate(), make_rational(30000, 1001));
        for (int f : {3, 0, 4}) {
            const auto read = (*reader)->read(f);
            ASSERT_TRUE(read.ok()) << read.error().message;
            EXPECT_EQ(read->pixels, pictures[std::size_t(f)].pixels);
        }
    }
    EXPECT_FALSE(LosslessVideoWriter::open(folder / "none" / "a.mkv", 64, 64, {30, 1}).ok());
}

}  // namespace
}  // namespace mien::media
