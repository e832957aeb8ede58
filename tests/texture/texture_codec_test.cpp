#include <gtest/gtest.h>
#include <sched.h>

#include <optional>

#include "core/parallel.hpp"
#include "core/picture_measures.hpp"
#include "encoder/stream_encoder.hpp"
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
INSTANTIATE_TEST_SUITE_P(Texture, EveryCodec, testing::ValuesIn(encoder::texture_codecs()),
                         [](const auto& test) { return test.param; });

TEST_P(EveryCodec, ComesBackCloseToWhatWentInFrameForFrame) {
    const Clip clip = painted_clip(128, 96, 25);
    const auto encoded = encoder::encode_texture(clip, options(10));
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    ASSERT_EQ(encoded->rungs[0].groups.size(), 3u);
    EXPECT_EQ(encoded->rungs[0].groups[0].objects.size(), 10u);
    EXPECT_EQ(encoded->rungs[0].groups[2].objects.size(), 5u);
    auto decoder = decoder_of(*encoded);
    std::int64_t expected = 0;
    for (const auto& group : encoded->rungs[0].groups) {
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

TEST_P(EveryCodec, DecodesEveryGroupAlone) {
    const auto encoded = encoder::encode_texture(painted_clip(101, 67, 13), options(5));
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    auto through = decoder_of(*encoded);
    for (const auto& group : encoded->rungs[0].groups) {
        auto alone = decoder_of(*encoded);
        const auto a = decode_group(through, group), b = decode_group(alone, group);
        ASSERT_TRUE(a.ok() && b.ok());
        ASSERT_EQ(a->size(), group.objects.size());
        for (std::size_t i = 0; i < a->size(); ++i) {
            EXPECT_EQ((*a)[i].frame, group.first_time + std::int64_t(i));
            const Image image = decoder::to_rgb((*a)[i].picture);
            EXPECT_EQ(image.width, 101);
            EXPECT_EQ(image.height, 67);
            EXPECT_EQ(image.pixels, decoder::to_rgb((*b)[i].picture).pixels);
        }
    }
}

TEST_P(EveryCodec, SaysBt709AndLimitedRangeAndMakesTheSameBytesTwice) {
    const Clip clip = painted_clip(128, 96, 3, 4);  // x265 3.5 wavers on pictures of a single 64 x 64 block
    const auto first = encoder::encode_texture(clip, options(3)),
               second = encoder::encode_texture(clip, options(3));
    ASSERT_TRUE(first.ok() && second.ok());
    EXPECT_EQ(first->rungs[0].codec_config, second->rungs[0].codec_config);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(first->rungs[0].groups[0].objects[i].bytes, second->rungs[0].groups[0].objects[i].bytes);
    // Alpha is ignored.
    const auto opaque = encoder::encode_texture(painted_clip(128, 96, 3, 3), options(3));
    ASSERT_TRUE(opaque.ok());
    EXPECT_EQ(opaque->rungs[0].groups[0].objects[0].bytes, first->rungs[0].groups[0].objects[0].bytes);

    // A track that claims otherwise: what the bitstream says wins. MPEG-4 Part 2 says nothing.
    protocol::Track lying = track_of(*first);
    std::get<protocol::TextureInfo>(lying.info).matrix = YuvView::Matrix::bt601;
    std::get<protocol::TextureInfo>(lying.info).full_range = true;
    auto decoder = std::move(*decoder::TextureDecoder::create(lying, lying.rungs[0]));
    const auto frames = decode_group(decoder, first->rungs[0].groups[0]);
    ASSERT_TRUE(frames.ok());
    const bool silent = GetParam() == "mpeg4";
    EXPECT_EQ((*frames)[0].picture.matrix, silent ? YuvView::Matrix::bt601 : YuvView::Matrix::bt709);
    EXPECT_EQ((*frames)[0].picture.full_range, silent);
}

/// One processor for all threads that are started meanwhile.
class OneProcessor {
public:
    OneProcessor() {
        sched_getaffinity(0, sizeof before_, &before_);
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++cpu)
            if (CPU_ISSET(cpu, &before_)) CPU_SET(cpu, &one);
        sched_setaffinity(0, sizeof one, &one);
    }
    ~OneProcessor() { sched_setaffinity(0, sizeof before_, &before_); }

private:
    cpu_set_t before_;
};

TEST_P(EveryCodec, MakesTheSameBytesOnOneProcessorAndOnAll) {
    const Clip clip = painted_clip(160, 128, 40);
    for (const bool by_rate : {true, false}) {
        encoder::TextureOptions wanted = options(10);
        if (by_rate) wanted.kbps = 200;
        else wanted.quality = 60;
        std::optional<encoder::EncodedTexture> first;
        for (int run = 0; run < (by_rate ? 4 : 2); ++run) {
            std::optional<OneProcessor> narrow;
            if (run % 2 == 1) narrow.emplace();
            auto encoded = encoder::encode_texture(clip, wanted);
            ASSERT_TRUE(encoded.ok()) << encoded.error().message;
            if (!first) first = std::move(*encoded);
            else
                for (std::size_t g = 0; g < first->rungs[0].groups.size(); ++g)
                    for (std::size_t o = 0; o < first->rungs[0].groups[g].objects.size(); ++o)
                        ASSERT_EQ(encoded->rungs[0].groups[g].objects[o].bytes, first->rungs[0].groups[g].objects[o].bytes)
                            << (by_rate ? "rate" : "quality") << ", run " << run << ", group " << g << ", object " << o;
        }
    }
}

TEST_P(EveryCodec, TakesFewerBitsForLessQuality) {
    const Clip clip = painted_clip(160, 128, 20);
    std::size_t last = 0;
    for (const double quality : {0.0, 40.0, 80.0, 100.0}) {
        encoder::TextureOptions wanted = options(10);
        wanted.quality = quality;
        const auto encoded = encoder::encode_texture(clip, wanted);
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;
        EXPECT_GT(double(bytes_of(*encoded)), 1.1 * double(last)) << quality;
        last = bytes_of(*encoded);
    }
}

TEST_P(EveryCodec, TakesAClipOfOneFrame) {
    const auto encoded = encoder::encode_texture(painted_clip(64, 64, 1), options(30));
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    auto decoder = decoder_of(*encoded);
    const auto frames = decode_group(decoder, encoded->rungs[0].groups.at(0));
    ASSERT_TRUE(frames.ok());
    EXPECT_EQ(frames->size(), 1u);
}

TEST_P(EveryCodec, GarbageNeverCrashesAndTheNextGroupDecodes) {
    const auto encoded = encoder::encode_texture(painted_clip(64, 64, 8), options(4));
    ASSERT_TRUE(encoded.ok());
    auto decoder = decoder_of(*encoded);
    const auto truth = decode_group(decoder, encoded->rungs[0].groups[1]);
    ASSERT_TRUE(truth.ok());
    std::uint32_t seed = 1;
    const auto random = [&] { return (seed = seed * 1664525 + 1013904223) >> 8; };
    for (int n = 0; n < 12; ++n) {
        protocol::Group damaged = encoded->rungs[0].groups[0];
        Bytes& bytes = damaged.objects[random() % 4].bytes;
        if (n % 3 == 0) bytes.resize(random() % (bytes.size() + 1));
        for (std::byte& b : bytes)
            if (n % 3 == 1 || random() % 64 == 0) b = std::byte(random());
        if (const auto answer = decode_group(decoder, damaged); answer.ok()) {
            EXPECT_EQ(answer->size(), 4u);
        }
        const auto again = decode_group(decoder, encoded->rungs[0].groups[1]);
        ASSERT_TRUE(again.ok()) << again.error().message;
        for (std::size_t i = 0; i < 4; ++i)
            EXPECT_EQ(decoder::to_rgb((*again)[i].picture).pixels,
                      decoder::to_rgb((*truth)[i].picture).pixels);
    }
    decoder.begin_group(0);
    EXPECT_FALSE(decoder.push({1, {}}).ok());
    EXPECT_FALSE(decoder.push(encoded->rungs[0].groups[0].objects[0]).ok())
        << "after an error it waits for the next group";
}

TEST(Texture, RefusesAPictureOfAnotherSizeThanAnnounced) {
    const auto encoded = encoder::encode_texture(painted_clip(128, 128, 2), {});
    ASSERT_TRUE(encoded.ok());
    for (const std::uint32_t side : {64u, 130u, 256u}) {
        protocol::Track lying = track_of(*encoded);
        std::get<protocol::TextureInfo>(lying.info).width = side;
        auto decoder = std::move(*decoder::TextureDecoder::create(lying, lying.rungs[0]));
        EXPECT_FALSE(decode_group(decoder, encoded->rungs[0].groups[0]).ok()) << side;
    }
}

TEST(Texture, MeetsTheBitrateAskedFor) {
    encoder::TextureOptions options;
    options.kbps = 60;
    options.group_frames = 15;
    options.speed = "fast";
    const auto encoded = encoder::encode_texture(painted_clip(128, 128, 90), options);
    ASSERT_TRUE(encoded.ok());
    EXPECT_NEAR(double(bytes_of(*encoded)) * 8 / 1000 / 3.0, 60, 6);
    EXPECT_EQ(encoded->rungs[0].asked_kbps, 60);
    EXPECT_NEAR(encoded->rungs[0].kbps, double(bytes_of(*encoded)) * 8 / 1000 / 3.0, 1e-9);
}

TEST(Texture, ARateThatIsMissedIsWarnedOfAndOneThatIsMetIsNot) {
    Clip clip = painted_clip(128, 128, 90);
    clip.weights.emplace(90, 1);
    encoder::StreamOptions options;
    options.motion.kind = protocol::MotionKind::weights;
    options.motion.rms = 0.1;
    options.group_seconds = 0.5;
    options.texture->speed = "fast";
    options.texture->rungs = {{1, 0}, {60, 0}, {1e5, 0}};
    const auto stream = encoder::encode_stream(clip, options);
    ASSERT_TRUE(stream.ok()) << stream.error().message;
    ASSERT_EQ(stream->warnings.size(), 2u);
    EXPECT_NE(stream->warnings[0].find("where 1 were asked: h264 came no nearer with pictures of 128 x 128 texels"), std::string::npos) << stream->warnings[0];
    EXPECT_NE(stream->warnings[1].find("where 1e+05 were asked"), std::string::npos) << stream->warnings[1];
}

TEST_P(EveryCodec, GoesAsLowAsItCanWhereARateCannotBeMet) {
    encoder::TextureOptions wanted = options(15);
    wanted.kbps = 1;
    const auto encoded = encoder::encode_texture(painted_clip(128, 128, 30), wanted);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    EXPECT_GT(encoded->rungs[0].kbps, 1);
    wanted.kbps = 30;
    const auto easy = encoder::encode_texture(painted_clip(128, 128, 30), wanted);
    ASSERT_TRUE(easy.ok()) << easy.error().message;
    EXPECT_LE(bytes_of(*encoded), bytes_of(*easy));
}

/// Counts how often its frames are read.
class CountedTexture final : public PaintedTexture {
public:
    using PaintedTexture::PaintedTexture;
    Result<Image> read(std::int64_t frame) override { return ++reads, PaintedTexture::read(frame); }
    std::int64_t reads = 0;
};

TEST_P(EveryCodec, EncodesAllRungsInOneReadingEachAsIfItWereAlone) {
    const auto texture = std::make_shared<CountedTexture>(128, 96, 24);
    Clip clip;
    clip.texture = texture;
    encoder::TextureOptions wanted = options(8);
    wanted.weighted = false;
    const double kbps[] = {40, 160, 400};
    wanted.rungs = {{kbps[0], 64}, {kbps[1], 0}, {kbps[2], 0}};
    const auto encoded = encoder::encode_texture(clip, wanted);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    EXPECT_LE(texture->reads, 3 * 24);   // again only for what misses its rate, all of that together
    ASSERT_EQ(encoded->rungs.size(), 3u);
    EXPECT_EQ(encoded->rungs[0].width, 64);
    EXPECT_EQ(encoded->rungs[0].height, 48);
    for (std::size_t r = 0; r < 3; ++r) {
        const auto& rung = encoded->rungs[r];
        ASSERT_EQ(rung.groups.size(), 3u);
        for (std::size_t g = 0; g < 3; ++g) {
            EXPECT_EQ(rung.groups[g].first_time, std::int64_t(8 * g));
            auto decoder = decoder_of(*encoded, 0, r);
            const auto frames = decode_group(decoder, rung.groups[g]);
            ASSERT_TRUE(frames.ok()) << frames.error().message;
            ASSERT_EQ(frames->size(), 8u);
            EXPECT_EQ(frames->front().picture.width, rung.width);
            EXPECT_EQ(frames->front().picture.height, rung.height);
        }
        if (r == 0) continue;
        encoder::TextureOptions alone = options(8);
        alone.weighted = false;
        alone.kbps = kbps[r];
        const auto single = encoder::encode_texture(clip, alone);
        ASSERT_TRUE(single.ok());
        for (std::size_t g = 0; g < 3; ++g)
            for (std::size_t o = 0; o < 8; ++o)
                ASSERT_EQ(single->rungs[0].groups[g].objects[o].bytes, rung.groups[g].objects[o].bytes) << "rung " << r;
    }
    EXPECT_LT(bytes_of(*encoded, 0), bytes_of(*encoded, 1));
}

TEST(Texture, RefusesRungsThatMakeNoLadder) {
    const Clip clip = painted_clip(128, 96, 2);
    encoder::TextureOptions options;
    for (const std::vector<encoder::TextureRung>& rungs : std::vector<std::vector<encoder::TextureRung>>{
             {{200, 0}, {100, 0}}, {{100, 0}, {100, 0}}, {{0, 0}}, {{100, 129}}, {{100, -1}}, [] {
                 std::vector<encoder::TextureRung> many;
                 for (int r = 1; r <= 17; ++r) many.push_back({10.0 * r, 0});
                 return many;
             }()}) {
        options.rungs = rungs;
        EXPECT_FALSE(encoder::encode_texture(clip, options).ok());
    }
    options.rungs = {{100, 0}};
    options.kbps = 100;
    EXPECT_FALSE(encoder::encode_texture(clip, options).ok());
}

/// Painted, with grain that creeps.
class GrainyTexture final : public PaintedTexture {
public:
    using PaintedTexture::PaintedTexture;
    Result<Image> read(std::int64_t frame) override {
        Image image = paint(frame);
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                std::uint32_t hash = std::uint32_t((y + frame / 2) * 4099 + x) * 2654435761u;
                hash = (hash ^ hash >> 15) * 2246822519u;
                for (int c = 0; c < 3; ++c) image.at(x, y)[c] = std::uint8_t(std::clamp(image.at(x, y)[c] + int(hash >> 16) % 41 - 20, 0, 255));
            }
        return image;
    }
};

/// A clip whose atlas shows two squares: the left one faces the viewer, the right one, as lively, faces away.
Clip two_sided_clip(std::int64_t frames) {
    Clip clip;
    clip.texture = std::make_shared<GrainyTexture>(128, 128, frames);
    Mesh mesh;
    mesh.positions.resize(8, 3);
    mesh.positions << 0, 0, 0, 100, 0, 0, 100, 100, 0, 0, 100, 0, 300, 0, 0, 200, 0, 0, 200, 100, 0, 300, 100, 0;
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    mesh.texcoords = {{0, 0}, {0.5f, 0}, {0.5f, 1}, {0, 1}, {0.5f, 0}, {1, 0}, {1, 1}, {0.5f, 1}};
    mesh.texcoord_triangles = mesh.triangles;
    clip.neutral = mesh;
    return clip;
}

TEST_P(EveryCodec, MakesTheSameRungsWithAnyNumberOfThreads) {
    const Clip clip = two_sided_clip(12);
    encoder::TextureOptions wanted = options(6);
    wanted.rungs = {{100, 96}, {300, 0}};  // x265 3.5 wavers on pictures of a single 64 x 64 block
    std::optional<encoder::EncodedTexture> first;
    for (const int threads : {1, 4}) {
        set_thread_count(threads);
        auto encoded = encoder::encode_texture(clip, wanted);
        set_thread_count(0);
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;
        if (!first) {
            first = std::move(*encoded);
            continue;
        }
        for (std::size_t r = 0; r < 2; ++r)
            for (std::size_t g = 0; g < 2; ++g)
                for (std::size_t o = 0; o < 6; ++o)
                    ASSERT_EQ(encoded->rungs[r].groups[g].objects[o].bytes, first->rungs[r].groups[g].objects[o].bytes) << "rung " << r;
    }
}

TEST(Texture, SpendsBitsOnWhatIsSeen) {
    const Clip clip = two_sided_clip(60);
    std::vector<std::uint8_t> seen(128 * 128);
    for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = i % 128 < 64;
    for (const std::string& codec : encoder::texture_codecs()) {
        double quality[2], kbps[2];
        for (const bool weighted : {false, true}) {
            encoder::TextureOptions options;
            options.codec = codec;
            options.kbps = 400;
            options.weighted = weighted;
            const auto encoded = encoder::encode_texture(clip, options);
            ASSERT_TRUE(encoded.ok()) << encoded.error().message;
            PictureComparison comparison(128, 128, seen);
            auto decoder = decoder_of(*encoded);
            for (const auto& group : encoded->rungs[0].groups) {
                const auto frames = decode_group(decoder, group);
                ASSERT_TRUE(frames.ok());
                for (const auto& frame : *frames) comparison.add(*clip.texture->read(frame.frame), decoder::to_rgb(frame.picture));
            }
            quality[weighted] = comparison.psnr_y();
            kbps[weighted] = double(bytes_of(*encoded)) * 8 / 1000 / 2;
        }
        // Rate control misses a little: half the bits would be about 3 dB.
        const double gain = quality[1] - quality[0] - 10 * std::log10(kbps[1] / kbps[0]);
        EXPECT_NEAR(kbps[1] / kbps[0], 1, 0.15) << codec;
        EXPECT_GT(gain, 1.0) << codec;
    }
}

TEST(Texture, NamesTheCodecsThereAre) {
    encoder::TextureOptions options;
    options.codec = "theora";
    const auto encoded = encoder::encode_texture(painted_clip(64, 64, 2), options);
    ASSERT_FALSE(encoded.ok());
    for (const std::string& name : encoder::texture_codecs())
        EXPECT_NE(encoded.error().message.find(name), std::string::npos);
    options.codec = "h264";
    options.speed = "no such preset";
    EXPECT_FALSE(encoder::encode_texture(painted_clip(64, 64, 2), options).ok());
}

}  // namespace
}  // namespace mien
