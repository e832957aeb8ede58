#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "decoder/av_sound.hpp"
#include "encoder/sound_encoder.hpp"

namespace mien {
namespace {

/// Noise through a low-pass, louder and softer: one best alignment, and what speech codecs keep.
Sound babble(int rate, int channels, double seconds) {
    Sound sound{rate, channels, {}};
    std::mt19937 random(7);
    std::vector<double> state(std::size_t(channels) * 2);
    for (int i = 0; i < int(seconds * rate); ++i)
        for (int c = 0; c < channels; ++c) {
            const double white = double(random()) / 4294967296.0 - 0.5;
            double &a = state[std::size_t(2 * c)], &b = state[std::size_t(2 * c + 1)];
            a += 0.15 * (white - a);
            b += 0.15 * (a - b);
            sound.samples.push_back(float(b * 4 * (0.6 + 0.4 * std::sin(20.0 * i / rate + c))));
        }
    return sound;
}

protocol::Track track_of(const encoder::EncodedSound& encoded) {
    protocol::Track track;
    track.kind = protocol::TrackKind::sound;
    track.time_base = encoded.time_base;
    track.info = encoded.info;
    protocol::Rung rung;
    rung.codec = encoded.codec;
    rung.codec_config = encoded.codec_config;
    track.rungs.push_back(rung);
    return track;
}

decoder::SoundDecoder decoder_of(const encoder::EncodedSound& encoded) {
    const protocol::Track track = track_of(encoded);
    return std::move(*decoder::SoundDecoder::create(track, track.rungs[0]));
}

/// The shift of `b` against `a` that correlates best, in samples; channel `c`.
int best_shift(const Sound& a, const Sound& b, int c) {
    double best = -1e30;
    int shift = 0;
    for (int s = -700; s <= 700; ++s) {
        double sum = 0;
        for (std::int64_t i = 2000; i < 14000; ++i)
            sum += double(a.samples[std::size_t(i * a.channels + c)]) *
                   b.samples[std::size_t((i + s) * b.channels + c)];
        if (sum > best) best = sum, shift = s;
    }
    return shift;
}

struct Case {
    std::string codec;
    int rate, channels;
};
class EverySound : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Sound, EverySound,
                         testing::Values(Case{"opus", 48000, 1}, Case{"opus", 44100, 2},
                                         Case{"opus", 16000, 1}, Case{"aac", 44100, 1}, Case{"aac", 48000, 2},
                                         Case{"opus", 48000, 6}),
                         [](const auto& test) {
                             return test.param.codec + std::to_string(test.param.rate) + "x" +
                                    std::to_string(test.param.channels);
                         });

TEST_P(EverySound, ComesBackAlignedToTheSampleWithoutGapsAndEveryGroupAlone) {
    const Case& c = GetParam();
    const Sound original = babble(c.rate, c.channels, 1.237);
    encoder::SoundOptions options;
    options.codec = c.codec;
    options.kbps = 64 * c.channels;
    options.group_frames = 9;
    options.frame_rate = {30000, 1001};
    options.frames = 27;  // 0.9 s: the sound is longer, its end belongs to the last group
    const auto encoded = encoder::encode_sound(original, options);
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    const int rate = int(encoded->info.sample_rate);
    EXPECT_EQ(encoded->time_base, make_rational(1, rate));
    EXPECT_EQ(rate, c.codec == "opus" ? 48000 : c.rate);
    const auto length = std::int64_t(encoded->info.samples);
    EXPECT_EQ(length, rescale(original.length(), {1, c.rate}, {1, rate}));
    ASSERT_EQ(encoded->groups.size(), 3u);

    auto decoder = decoder_of(*encoded);
    Sound joined{rate, c.channels, {}};
    for (std::size_t g = 0; g < 3; ++g) {
        const auto& group = encoded->groups[g];
        EXPECT_EQ(group.group, g);
        // The group in which it starts, and not one packet before.
        EXPECT_GE(double(group.first_time) / rate, double(g) * 0.3003 - 1e-9);
        EXPECT_LT(double(group.first_time) / rate,
                  double(g) * 0.3003 + double(encoded->info.packet_samples) / rate);
        const auto block = decoder.decode(group);
        ASSERT_TRUE(block.ok()) << block.error().message;
        EXPECT_EQ(block->first_sample, joined.length());
        joined.samples.insert(joined.samples.end(), block->sound.samples.begin(), block->sound.samples.end());
    }
    ASSERT_EQ(joined.length(), length);

    auto alone = decoder_of(*encoded);
    const auto last = alone.decode(encoded->groups[2]);
    ASSERT_TRUE(last.ok());
    EXPECT_TRUE(std::equal(last->sound.samples.begin(), last->sound.samples.end(),
                           joined.samples.end() - std::ptrdiff_t(last->sound.samples.size())));

    if (c.rate == rate) {
        for (int channel = 0; channel < c.channels; ++channel) {
            if (c.channels == 6 && channel == 3) continue;  // the low-frequency channel keeps only the lowest
            EXPECT_EQ(best_shift(original, joined, channel), 0) << "channel " << channel;
        }
    }
    // Joins are no worse than the rest: the error around them against the error everywhere.
    if (c.rate == rate && c.channels == 1) {
        const auto rms = [&](std::int64_t from, std::int64_t to) {
            double sum = 0;
            for (std::int64_t i = from; i < to; ++i)
                sum += std::pow(double(original.samples[std::size_t(i)]) - joined.samples[std::size_t(i)], 2);
            return std::sqrt(sum / double(to - from));
        };
        const double everywhere = rms(0, length);
        for (std::size_t g = 1; g < 3; ++g) {
            const std::int64_t join = encoded->groups[g].first_time;
            EXPECT_LT(rms(join - 240, join + 240), 2.5 * everywhere) << "group " << g;
        }
    }
}

TEST(Sound, EndsWhereItEndsWhenThePictureGoesOn) {
    encoder::SoundOptions options;
    options.group_frames = 10;
    options.frame_rate = {25, 1};
    options.frames = 1000;
    const auto encoded = encoder::encode_sound(babble(48000, 1, 0.5), options);
    ASSERT_TRUE(encoded.ok());
    ASSERT_EQ(encoded->groups.size(), 2u);
    auto decoder = decoder_of(*encoded);
    const auto block = decoder.decode(encoded->groups[1]);
    ASSERT_TRUE(block.ok());
    EXPECT_EQ(block->first_sample, 19200);
    EXPECT_EQ(block->sound.length(), 24000 - 19200);
}

TEST(Sound, TakesNoMoreThanAskedWithAllThatIsSaidTwice) {
    const Sound original = babble(48000, 1, 5);
    for (const char* codec : {"opus", "aac"})
        for (const double kbps : {32.0, 64.0}) {
            encoder::SoundOptions options;
            options.codec = codec;
            options.kbps = kbps;
            options.frames = 150;
            const auto encoded = encoder::encode_sound(original, options);
            ASSERT_TRUE(encoded.ok()) << encoded.error().message;
            std::size_t bytes = 0;
            for (const auto& group : encoded->groups)
                for (const auto& object : group.objects) bytes += object.bytes.size();
            EXPECT_LT(8e-3 * double(bytes) / 5, 1.02 * kbps) << codec;
            EXPECT_GT(8e-3 * double(bytes) / 5, 0.8 * kbps) << codec;
        }
}

TEST(Sound, RefusesWhatIsNoSound) {
    encoder::SoundOptions options;
    Sound sound = babble(48000, 2, 0.1);
    sound.samples[77] = NAN;
    const auto with_nan = encoder::encode_sound(sound, options);
    ASSERT_FALSE(with_nan.ok());
    EXPECT_NE(with_nan.error().message.find("sample 38"), std::string::npos) << with_nan.error().message;
    options.codec = "vorbis";
    const auto unknown = encoder::encode_sound(babble(48000, 1, 0.1), options);
    ASSERT_FALSE(unknown.ok());
    EXPECT_NE(unknown.error().message.find("opus, aac"), std::string::npos) << unknown.error().message;
}

TEST(Sound, GarbageIsAnErrorAndTheNextGroupDecodes) {
    for (const std::string codec : {"opus", "aac"}) {
        encoder::SoundOptions options;
        options.codec = codec;
        options.group_frames = 3;
        const auto encoded = encoder::encode_sound(babble(48000, 1, 0.3), options);
        ASSERT_TRUE(encoded.ok());
        auto decoder = decoder_of(*encoded);
        const auto truth = decoder.decode(encoded->groups[1]);
        ASSERT_TRUE(truth.ok());
        std::mt19937 random(3);
        for (int n = 0; n < 60; ++n) {
            protocol::Group damaged = encoded->groups[1];
            auto& bytes = damaged.objects[random() % damaged.objects.size()].bytes;
            if (n % 3 == 0) bytes.resize(random() % (bytes.size() + 1));
            for (std::byte& b : bytes)
                if (random() % 4 == 0) b = std::byte(random());
            (void)decoder.decode(damaged);  // any answer will do; no crash
            const auto again = decoder.decode(encoded->groups[1]);
            ASSERT_TRUE(again.ok());
            ASSERT_EQ(again->sound.samples, truth->sound.samples);
        }
        protocol::Group empty = encoded->groups[1];
        empty.objects[2].bytes.clear();
        EXPECT_FALSE(decoder.decode(empty).ok());
    }
}

}  // namespace
}  // namespace mien
