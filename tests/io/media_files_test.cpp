#include <gtest/gtest.h>

#include <cmath>

#include "core/environment_error.hpp"
#include "io/file.hpp"
#include "io/image_file.hpp"
#include "io/sound_file.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

using tests::TemporaryFolder;

TEST(ImageFile, PngComesBackExactlyAndJpegNearly) {
    const TemporaryFolder folder;
    Image image(17, 11, 3);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = std::uint8_t(i / 3);
    write_image(folder / "a.png", image);
    write_image(folder / "a.jpg", image);
    const auto png = read_image(folder / "a.png"), jpg = read_image(folder / "a.jpg");
    ASSERT_TRUE(png && jpg);
    EXPECT_EQ(png->pixels, image.pixels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) EXPECT_NEAR(jpg->pixels[i], image.pixels[i], 12);
    EXPECT_THROW(write_image(folder / "no" / "a.png", image), EnvironmentError);
}

TEST(ImageFile, JpegGivesItsSizeItsGreyAndNoAlpha) {
    const TemporaryFolder folder;
    Image image(10, 7, 3);
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) image.pixels[i] = 200;
    write_image(folder / "a.jpg", image);
    const auto size = read_image_size(folder / "a.jpg");
    ASSERT_TRUE(size);
    EXPECT_EQ(size->width, 10);
    EXPECT_EQ(size->height, 7);
    bool alpha = true;
    const auto grey = read_image(folder / "a.jpg", 1, &alpha);
    ASSERT_TRUE(grey);
    EXPECT_FALSE(alpha);
    ASSERT_EQ(grey->pixels.size(), 70u);
    EXPECT_NEAR(grey->pixels[35], 60, 4);   // 0.299 of 200
}

TEST(ImageFile, AJpegWithMoreHuffmanCodesThanBytesHaveIsRefused) {
    const unsigned char jpeg[] = {0xff, 0xd8, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xc4, 0x01, 0x00, 0x00, 0x00, 0x1a, 0x00, 0xff, 0xff, 0xff, 0xff};
    const auto* begin = reinterpret_cast<const std::byte*>(jpeg);
    EXPECT_FALSE(parse_image(Bytes(begin, begin + sizeof jpeg)));
}

TEST(ImageFile, AlphaIsLeftOutAndSaidSo) {
    const TemporaryFolder folder;
    Image image(2, 1, 4);
    image.pixels = {10, 20, 30, 0, 40, 50, 60, 255};
    write_image(folder / "a.png", image);
    bool alpha = false;
    const auto read = read_image(folder / "a.png", 3, &alpha);
    ASSERT_TRUE(read);
    EXPECT_TRUE(alpha);
    EXPECT_EQ(read->pixels, (std::vector<std::uint8_t>{10, 20, 30, 40, 50, 60}));
}

TEST(ImageFile, EveryTruncationIsRefusedOrShort) {
    const TemporaryFolder folder;
    write_image(folder / "a.png", Image(9, 9, 3));
    const auto bytes = read_bytes(folder / "a.png");
    ASSERT_TRUE(bytes);
    for (std::size_t n = 0; n + 16 < bytes->size(); ++n)
        EXPECT_FALSE(parse_image(Bytes(bytes->begin(), bytes->begin() + std::ptrdiff_t(n)))) << n;
    EXPECT_EQ(read_image(folder / "none.png").error().code, ErrorCode::missing);
}

TEST(ImageFile, AChunkLongerThanTheFileIsRefusedBeforeRoomIsMadeForIt) {
    const TemporaryFolder folder;
    write_image(folder / "a.png", Image(3, 2, 3));
    auto bytes = read_bytes(folder / "a.png").value();
    ASSERT_EQ(std::to_integer<char>(bytes[37]), 'I');  // IDAT, its length before it
    bytes[33] = std::byte(0x3f);                       // 1 GB
    EXPECT_EQ(parse_image(bytes).error().code, ErrorCode::truncated);
}

TEST(ImageFile, MorePixelsThanItsBytesCanHoldAreRefusedBeforeTheyArePainted) {
    // An RLE TGA file of 6168 x 6168 in 20 bytes, which ends inside its first packet.
    const unsigned char tga[] = {0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x18, 0x18, 0x18, 0x18, 24, 0, 0x83, 1};
    const auto* begin = reinterpret_cast<const std::byte*>(tga);
    EXPECT_EQ(parse_image(Bytes(begin, begin + sizeof tga)).error().code, ErrorCode::truncated);
    const TemporaryFolder folder;
    Image black(4000, 4000, 1);   // what packs best
    write_image(folder / "black.png", black);
    EXPECT_TRUE(read_image(folder / "black.png").ok());
}

TEST(ImageFile, AnEmptyChunkOfPixelsIsRefusedBeforeTheFirstAndReadAfterIt) {
    const TemporaryFolder folder;
    write_image(folder / "a.png", Image(3, 2, 3));
    const auto whole = read_bytes(folder / "a.png");
    ASSERT_TRUE(whole);
    const auto with_empty_chunk = [&](std::size_t at) {
        const unsigned char chunk[] = {0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e};
        Bytes bytes(whole->begin(), whole->end());
        const auto* begin = reinterpret_cast<const std::byte*>(chunk);
        bytes.insert(bytes.begin() + std::ptrdiff_t(at), begin, begin + sizeof chunk);
        return bytes;
    };
    constexpr std::size_t kAfterHeader = 8 + 25, kEnd = 12;
    EXPECT_EQ(parse_image(with_empty_chunk(kAfterHeader)).error().code, ErrorCode::damaged);
    EXPECT_TRUE(parse_image(with_empty_chunk(whole->size() - kEnd)).ok());
}

TEST(SoundFile, WavComesBack) {
    const TemporaryFolder folder;
    Sound sound{44100, 2, {}};
    for (int i = 0; i < 2000; ++i) sound.samples.push_back(std::sin(0.01f * float(i)) * 1.2f);
    write_wav(folder / "a.wav", sound);
    const auto read = read_sound(folder / "a.wav");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->sample_rate, 44100);
    EXPECT_EQ(read->channels, 2);
    ASSERT_EQ(read->samples.size(), sound.samples.size());
    for (std::size_t i = 0; i < sound.samples.size(); ++i) EXPECT_NEAR(read->samples[i], std::min(std::max(sound.samples[i], -1.0f), 1.0f), 1e-4);
    write_file(folder / "b.wav", "not a sound");
    EXPECT_EQ(read_sound(folder / "b.wav").error().code, ErrorCode::damaged);
    EXPECT_EQ(read_sound(folder / "c.wav").error().code, ErrorCode::missing);
}

}  // namespace
}  // namespace mien::io
