#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "encoder/live_sound.hpp"
#include "media/sound_codec.hpp"

namespace mien::encoder {
namespace {

/// Speech-like noise, louder and softer.
Sound babble(int rate, int channels, double seconds) {
    Sound sound{rate, channels, {}};
    std::mt19937 random(7);
    const double keep = std::exp(-2 * 3.14159 * 1500 / rate);   // 1.5 kHz, whatever the rate
    double a = 0, b = 0;
    for (int i = 0; i < int(seconds * rate); ++i) {
        a += (1 - keep) * (double(random()) / 4294967296.0 - 0.5 - a);
        b += (1 - keep) * (a - b);
        for (int c = 0; c < channels; ++c) sound.samples.push_back(float((c == 0 ? b : 0.5 * b) * 2 * (0.6 + 0.4 * std::sin(20.0 * i / rate))));
    }
    return sound;
}

Sound part(const Sound& sound, std::int64_t first, std::int64_t count) {
    return {sound.sample_rate, sound.channels, {sound.samples.begin() + first * sound.channels, sound.samples.begin() + (first + count) * sound.channels}};
}

/// What is decoded of packets, at their positions.
struct Heard {
    media::PacketSoundDecoder decoder;
    std::vector<float> samples;
    std::int64_t first = 0;

    explicit Heard(const LiveSound& sound)
        : decoder(std::move(*media::PacketSoundDecoder::open("opus", sound.codec_config(), int(sound.info().sample_rate), sound.info().channels))) {
        std::vector<float> swallowed;
        for (const Bytes& packet : sound.lead()) EXPECT_TRUE(decoder.decode(packet, swallowed).ok());
    }
    void add(const LiveSound::Packet& packet) {
        if (samples.empty()) first = packet.position;
        EXPECT_TRUE(decoder.decode(packet.bytes, samples).ok());
    }
};

double energy_of_difference(const std::vector<float>& heard, std::int64_t first, const Sound& truth, std::int64_t shift) {
    double difference = 0, energy = 0;
    for (std::size_t i = 2000; i + 2000 < heard.size(); ++i) {
        const std::int64_t at = first + std::int64_t(i) + shift;
        if (at < 0 || at >= truth.length()) continue;
        const double t = double(truth.samples[std::size_t(at * truth.channels)]);
        difference += (double(heard[i]) - t) * (double(heard[i]) - t);
        energy += t * t;
    }
    return difference / energy;
}

TEST(LiveSound, PacketsOfTenMillisecondsAreWhereTheySayTheyAre) {
    const Sound truth = babble(48000, 1, 2);
    auto sound = LiveSound::open({48000, 1, 64});
    ASSERT_TRUE(sound.ok()) << sound.error().message;
    Heard heard(*sound);
    std::size_t packets = 0;
    std::int64_t expected = 0;
    for (std::int64_t at = 0; at + 1000 <= truth.length(); at += 1000) {   // as it comes from anywhere
        const auto made = sound->add(5'000'000 + at, part(truth, at, 1000));
        ASSERT_TRUE(made.ok()) << made.error().message;
        for (const auto& packet : *made) {
            EXPECT_EQ(packet.anew, packets == 0);
            if (packets++ > 0) {
                EXPECT_EQ(packet.position, expected);
            }
            expected = packet.position + 480;
            heard.add(packet);
        }
    }
    EXPECT_EQ(packets, 200u);
    EXPECT_EQ(heard.samples.size(), 96'000u);
    const double here = energy_of_difference(heard.samples, heard.first, truth, -5'000'000);
    EXPECT_LT(here, 0.1);
    for (const int off : {-24, -12, 12, 24}) EXPECT_GT(energy_of_difference(heard.samples, heard.first, truth, -5'000'000 + off), here) << off;
}

TEST(LiveSound, OtherRatesAndTwoChannelsKeepTheirTime) {
    const Sound truth = babble(44100, 2, 2);
    auto sound = LiveSound::open({44100, 2, 96});
    ASSERT_TRUE(sound.ok());
    Heard heard(*sound);
    for (std::int64_t at = 0; at + 441 <= truth.length(); at += 441) {
        const auto made = sound->add(441'000 + at, part(truth, at, 441));
        ASSERT_TRUE(made.ok());
        for (const auto& packet : *made) heard.add(packet);
    }
    const auto full = media::resample(truth, 48000);
    ASSERT_TRUE(full.ok());
    std::vector<float> left;
    for (std::size_t i = 0; i < heard.samples.size(); i += 2) left.push_back(heard.samples[i]);
    const double here = energy_of_difference(left, heard.first, *full, -480'000);
    EXPECT_LT(here, 0.1);
    for (const int off : {-48, 48}) EXPECT_GT(energy_of_difference(left, heard.first, *full, -480'000 + off), here) << "within a millisecond, filter and all";
    EXPECT_EQ(sound->add(0, babble(48000, 2, 0.1)).error().code, ErrorCode::mismatch);
    EXPECT_EQ(sound->add(0, babble(44100, 1, 0.1)).error().code, ErrorCode::mismatch);
}

TEST(LiveSound, WhatIsLostIsSilentAndWhatComesTwiceIsLeftOut) {
    const Sound truth = babble(48000, 1, 3);
    auto sound = LiveSound::open({48000, 1, 64});
    ASSERT_TRUE(sound.ok());
    std::int64_t count = 0, last = -1;
    int anew = 0;
    const auto give = [&](std::int64_t first, std::int64_t at, std::int64_t samples) {
        const auto made = sound->add(first, part(truth, at, samples));
        ASSERT_TRUE(made.ok());
        for (const auto& packet : *made) ++count, anew += packet.anew, last = packet.position;
    };
    give(0, 0, 4800);
    give(0, 0, 4800);          // twice
    give(2400, 2400, 4800);    // half of it
    EXPECT_EQ(count, 15);
    give(9600, 9600, 4800);    // 50 ms lost
    EXPECT_EQ(count, 30);
    EXPECT_EQ(anew, 1);
    const std::int64_t before = last;
    give(14'400 + 60'000, 20'000, 4800);   // more than a second: another time
    EXPECT_EQ(count, 40);
    EXPECT_EQ(anew, 2);
    EXPECT_EQ(last - before, 480 * 10 + 60'000);
    give(7, 0, 4800);          // and back
    EXPECT_EQ(anew, 3);
    EXPECT_LT(last, 4800);
}

TEST(LiveSound, AfterItsPreRollADecoderIsWhereTheOthersAre) {
    const Sound truth = babble(48000, 1, 2);
    auto sound = LiveSound::open({48000, 1, 48});
    ASSERT_TRUE(sound.ok());
    const auto packets = sound->add(0, truth);
    ASSERT_TRUE(packets.ok());
    const std::size_t preroll = sound->info().preroll / sound->info().packet_samples;
    const auto decode = [&](std::size_t from, std::size_t to, std::size_t keep) {
        auto decoder = media::PacketSoundDecoder::open("opus", sound->codec_config(), 48000, 1);
        std::vector<float> samples;
        for (std::size_t i = from; i < to; ++i) EXPECT_TRUE(decoder->decode((*packets)[i].bytes, samples).ok());
        return std::vector<float>(samples.end() - std::ptrdiff_t(480 * keep), samples.end());
    };
    double difference = 0, energy = 0;
    for (const std::size_t join : {50u, 77u, 120u, 171u}) {
        const auto all = decode(0, join + 20, 20), late = decode(join - preroll, join + 20, 20);
        for (std::size_t i = 0; i < all.size(); ++i) difference += std::pow(double(all[i] - late[i]), 2), energy += std::pow(double(all[i]), 2);
    }
    EXPECT_LT(difference, 1e-3 * energy);
}

TEST(LiveSound, WhatNoEncoderTakesIsRefused) {
    EXPECT_FALSE(LiveSound::open({48000, 0, 48}).ok());
    EXPECT_FALSE(LiveSound::open({48000, 1, -3}).ok());
}

}  // namespace
}  // namespace mien::encoder
