#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

#include "core/environment_error.hpp"
#include "core/picture_measures.hpp"
#include "media/video_reader.hpp"
#include "media/video_writer.hpp"

namespace mien::media {
namespace {

/// Frame `n`, told apart from every other at a glance.
Image numbered(int w, int h, int n) {
    Image image(w, h, 3);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            image.at(x, y)[0] = std::uint8_t(20 + 7 * n);
            image.at(x, y)[1] = std::uint8_t(128 + 90 * std::sin(0.05 * x + n));
            image.at(x, y)[2] = std::uint8_t(y * 255 / h);
        }
    return image;
}

class VideoFile : public testing::Test {
protected:
    std::filesystem::path folder_ =
        std::filesystem::temp_directory_path() / ("mien-video-test-" + std::to_string(::getpid()));
    void SetUp() override { std::filesystem::create_directories(folder_); }
    void TearDown() override { std::filesystem::remove_all(folder_); }
};

TEST_F(VideoFile, LosslessGivesEveryPixelBackInAnyOrder) {
    const auto path = folder_ / "a.mkv";
    VideoWriter writer = VideoWriter::lossless(path, 33, 21, {24000, 1001});
    for (int n = 0; n < 12; ++n) writer.write(numbered(33, 21, n));
    EXPECT_FALSE(std::filesystem::exists(path)) << "unfinished files have another name";
    writer.finish();
    auto reader = VideoReader::open(path);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_EQ((*reader)->frames(), 12);
    EXPECT_EQ((*reader)->width(), 33);
    EXPECT_EQ((*reader)->frame_rate(), make_rational(24000, 1001));
    for (const int n : {0, 1, 2, 11, 3, 3, 10, 0, 5})
        EXPECT_EQ((*reader)->read(n)->pixels, numbered(33, 21, n).pixels) << n;
}

TEST_F(VideoFile, LosslessKeepsNoiseThatCannotBeCompressed) {
    std::minstd_rand random(1);
    std::vector<Image> pictures(3, Image(96, 80, 3));
    VideoWriter writer = VideoWriter::lossless(folder_ / "noise.mkv", 96, 80, {30, 1});
    for (Image& picture : pictures) {
        for (std::uint8_t& p : picture.pixels) p = std::uint8_t(random() >> 7);
        writer.write(picture);
    }
    writer.finish();
    auto reader = VideoReader::open(folder_ / "noise.mkv");
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    for (const int n : {2, 0, 1}) EXPECT_EQ((*reader)->read(n)->pixels, pictures[std::size_t(n)].pixels) << n;
}

TEST_F(VideoFile, AMovieReadsByExactFrameNumberAcrossKeyFramesAndReordering) {
    const auto path = folder_ / "b.mp4";
    VideoWriter::Movie options;
    options.sound = Sound{48000, 1, std::vector<float>(48000, 0.1f)};
    options.speed = "medium";  // with pictures out of order
    VideoWriter writer = VideoWriter::movie(path, 65, 49, {30, 1}, options);
    for (int n = 0; n < 30; ++n) writer.write(numbered(65, 49, n));
    writer.finish();
    auto reader = VideoReader::open(path);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    ASSERT_EQ((*reader)->frames(), 30);
    for (const int n : {0, 1, 2, 3, 29, 0, 17, 18, 7, 28}) {
        const Image read = *(*reader)->read(n);
        EXPECT_EQ(read.width, 66);
        EXPECT_NEAR(read.at(30, 20)[0], 20 + 7 * n, 3) << "frame " << n;
    }
}

TEST_F(VideoFile, SaysWhatIsWrongWithAFile) {
    EXPECT_EQ(VideoReader::open(folder_ / "none.mp4").error().code, ErrorCode::unavailable);
    std::ofstream(folder_ / "text.mp4") << "this is no video at all, whatever its name says";
    EXPECT_FALSE(VideoReader::open(folder_ / "text.mp4").ok());
    EXPECT_THROW((void)VideoWriter::lossless(folder_ / "no" / "such" / "folder.mkv", 8, 8, {30, 1}),
                 EnvironmentError);
    { VideoWriter given_up = VideoWriter::lossless(folder_ / "c.mkv", 8, 8, {30, 1}); }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "c.mkv"));
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
        EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace mien::media
