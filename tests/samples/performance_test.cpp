#include "samples/performance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "samples/performance_liveliness.hpp"
#include "samples/viseme.hpp"

namespace mien::samples {
namespace {

std::size_t at(std::string_view name) { return std::size_t(arkit_index(name)); }

/// Speech without a synthesiser: sounds of a tenth of a second each, with a tone for a voice; an empty name is a pause.
Utterance spoken(const std::vector<std::string>& sounds, double each = 0.1) {
    Utterance u;
    for (std::size_t i = 0; i < sounds.size(); ++i) u.phonemes.push_back({sounds[i], double(i) * each, double(i + 1) * each});
    const auto length = std::size_t(std::lround(double(sounds.size()) * each * 48000));
    for (std::size_t n = 0; n < length; ++n) u.sound.samples.push_back(0.3f * std::sin(0.02f * float(n)));
    u.words = {{0, double(sounds.size()) * each, 0}};
    return u;
}

TEST(Speech, LipsMeetInTheMiddleOfBilabialsAndPartForVowels) {
    const MouthTrack mouth(spoken({"a", "p", "a", "b", "a", "m", "a"}));
    for (int i : {1, 3, 5}) {
        float most = 0;
        for (double t = i * 0.1 - 0.05; t < i * 0.1 + 0.1; t += 0.004) {
            std::array<float, kArkitCount> w{};
            add_mouth(mouth.at(t), w);
            if (w[at("JawOpen")] > 0.01f) most = std::max(most, w[at("MouthClose")] / w[at("JawOpen")]);
        }
        EXPECT_FLOAT_EQ(most, 1.f) << "sound " << i;
    }
    for (double start : {0.2, 0.4}) {
        float least = 1;
        for (double t = start; t < start + 0.1; t += 0.004) {
            std::array<float, kArkitCount> w{};
            add_mouth(mouth.at(t), w);
            EXPECT_GT(w[at("JawOpen")], 0.05f) << t;
            least = std::min(least, w[at("MouthClose")] / w[at("JawOpen")]);
        }
        EXPECT_LT(least, 0.35f) << start;
    }
}

TEST(Speech, EveryBilabialIsSeenClosedEvenAtTwentyFourFramesASecond) {
    const Utterance u = spoken({"", "", "a", "p", "a", "", "", "", "", ""}, 0.04);
    for (int shift = 0; shift < 8; ++shift) {
        Utterance shifted = u;
        for (Phoneme& p : shifted.phonemes) p.start += shift / 192.0, p.end += shift / 192.0;
        const MouthTrack mouth(shifted);
        float most = 0;
        for (int f = 0; f < 12; ++f) most = std::max(most, mouth.at(f / 24.0)[kClose]);
        EXPECT_GT(most, 0.94f) << shift;
    }
}

TEST(Speech, TheLowerLipTucksForFAndV) {
    const MouthTrack mouth(spoken({"a", "f", "a", "v", "a"}));
    EXPECT_GT(mouth.at(0.13)[kTuck], 0.9f);
    EXPECT_GT(mouth.at(0.33)[kTuck], 0.9f);
    EXPECT_LT(std::min(mouth.at(0.22)[kTuck], mouth.at(0.24)[kTuck]), 0.5f);
}

TEST(Speech, RoundingBeginsBeforeTheRoundedSound) {
    const MouthTrack mouth(spoken({"s", "t", "u", "s", "t"}));
    EXPECT_GT(mouth.at(0.15)[kRound], 0.3f);                          // 50 ms ahead
    EXPECT_GT(mouth.at(0.15)[kRound], mouth.at(0.40)[kRound]);        // and sooner than it goes
    EXPECT_GT(mouth.at(0.25)[kRound], 0.6f);
}

TEST(Speech, SoundsKeepTheirTimes) {
    // One open vowel in a row of closed ones: the jaw is lowest while it sounds.
    const MouthTrack mouth(spoken({"s", "s", "s", "ɑ", "s", "s", "s"}));
    double lowest = 0;
    for (double t = 0; t < 0.7; t += 0.004)
        if (mouth.at(t)[kJaw] > mouth.at(lowest)[kJaw]) lowest = t;
    EXPECT_GT(lowest, 0.30);
    EXPECT_LT(lowest, 0.40);
}

TEST(Speech, TheMouthRestsBeforeAndAfter) {
    const MouthTrack mouth(spoken({"a", "a"}));
    for (double t : {-5.0, -0.4, 0.6, 9.0})
        for (float a : mouth.at(t)) EXPECT_NEAR(a, 0, 1e-3f);
}

TEST(Performance, FrameCountsAreExactAtEveryRate) {
    const Utterance u = spoken({"m", "a", "m", "a"});
    for (const auto& [rate, frames] : {std::pair{Rational{24, 1}, 240}, {Rational{25, 1}, 250}, {Rational{30, 1}, 300},
                                       {Rational{60, 1}, 600}, {make_rational(30000, 1001), 300}}) {
        const Performance p = perform_speech(u, rate, 10, 1);
        EXPECT_EQ(p.frames(), frames);
        EXPECT_EQ(p.frame_rate, rate);
        EXPECT_NEAR(p.sound->seconds(), p.seconds(), 1.0 / 48000);
        EXPECT_EQ(perform_expressions(rate, 10, 1).frames(), frames);
    }
}

TEST(Performance, IsTheSameForTheSameSeedAndAnotherForAnother) {
    const auto same = [](const Performance& a, const Performance& b) {
        for (std::size_t f = 0; f < a.instants.size(); ++f)
            if (a.instants[f].weights != b.instants[f].weights || a.instants[f].head.translation != b.instants[f].head.translation)
                return false;
        return a.instants.size() == b.instants.size();
    };
    const Utterance u = spoken({"h", "ə", "l", "əʊ"});
    const Performance first = perform_speech(u, {30, 1}, 6, 7);
    EXPECT_TRUE(same(first, perform_speech(u, {30, 1}, 6, 7)));
    EXPECT_FALSE(same(first, perform_speech(u, {30, 1}, 6, 8)));
}

TEST(Performance, ShowsTheSameMomentAtEveryFrameRate) {
    const Utterance u = spoken({"m", "a", "u", "a"});
    const Performance slow = perform_speech(u, {30, 1}, 4, 3), fast = perform_speech(u, {60, 1}, 4, 3);
    for (std::size_t f = 0; f < slow.instants.size(); ++f)
        for (std::size_t i = 0; i < kArkitCount; ++i)
            ASSERT_FLOAT_EQ(slow.instants[f].weights[i], fast.instants[2 * f].weights[i]) << f << " " << kArkitNames[i];
}

TEST(Performance, WeightsStayInRangeAndTheFaceIsNeverFrozen) {
    for (const Performance& p : {perform_speech(spoken({"m", "a", "f", "u"}), {30, 1}, 12, 5), perform_expressions({30, 1}, 12, 5)})
        for (std::size_t f = 0; f < p.instants.size(); ++f) {
            for (float w : p.instants[f].weights) ASSERT_TRUE(w >= 0 && w <= 1);
            if (f > 0) {
                ASSERT_NE(p.instants[f].head.translation, p.instants[f - 1].head.translation);
            }
        }
}

TEST(Performance, LidsDoNotChatterAndBlinksCloseTheEyes) {
    const Liveliness life(60, {}, {}, 11);
    ASSERT_GE(life.blinks().size(), 10u);
    ASSERT_LE(life.blinks().size(), 35u);
    for (double start : life.blinks()) {
        if (start > 59.5) continue;
        // Seen closed at every rate: the middle of a blink lasts longer than a frame of 24 Hz.
        float most = 0;
        for (int f = int(std::ceil(start * 24)); f < (start + 0.35) * 24; ++f) {
            Instant instant;
            life.add(f / 24.0, instant);
            most = std::max(most, instant.weights[at("EyeBlinkRight")]);
        }
        EXPECT_GT(most, 0.9f) << start;
        Instant before, after;
        life.add(start, before);
        life.add(start + 0.36, after);
        EXPECT_NEAR(before.weights[at("EyeBlinkRight")], 0, 0.05f);
        EXPECT_NEAR(after.weights[at("EyeBlinkRight")], 0, 0.05f);
    }
}

TEST(Performance, RepeatsFromItsStartAndCutsAtItsEnd) {
    Performance p{{10, 1}, std::vector<Instant>(20), Sound{1000, 1, std::vector<float>(2000)}};
    for (std::size_t f = 0; f < 20; ++f) p.instants[f].weights[0] = float(f) / 20;
    for (std::size_t n = 0; n < 2000; ++n) p.sound->samples[n] = float(n) / 2000;
    const Performance twice = fit_length(p, 4.5);
    ASSERT_EQ(twice.frames(), 45);
    EXPECT_EQ(twice.instants[30].weights[0], p.instants[10].weights[0]);
    EXPECT_EQ(twice.sound->length(), 4500);
    EXPECT_EQ(twice.sound->samples[2500], p.sound->samples[500]);
    const Performance cut = fit_length(p, 0.5);
    EXPECT_EQ(cut.frames(), 5);
    EXPECT_EQ(cut.sound->length(), 500);
}

TEST(Performance, ResamplingMeetsTheOriginalFrames) {
    const Performance p = perform_expressions({30, 1}, 2, 1);
    const Performance fast = resample(p, {60, 1});
    ASSERT_EQ(fast.frames(), 120);
    for (std::size_t f = 0; f + 1 < 60; ++f)
        for (std::size_t i = 0; i < kArkitCount; ++i) {
            EXPECT_NEAR(fast.instants[2 * f].weights[i], p.instants[f].weights[i], 1e-5f);
            EXPECT_NEAR(fast.instants[2 * f + 1].weights[i], 0.5f * (p.instants[f].weights[i] + p.instants[f + 1].weights[i]), 1e-5f);
        }
}

TEST(Gaze, WeightsAndAnglesStandForEachOther) {
    Gaze gaze;
    gaze.yaw[0] = 0.2f, gaze.yaw[1] = -0.1f, gaze.pitch[0] = -0.15f, gaze.pitch[1] = 0.3f;
    std::array<float, kArkitCount> w{};
    look(gaze, w);
    EXPECT_GT(w[at("EyeLookInRight")], 0);   // the right eye to the actor's left is inward
    EXPECT_GT(w[at("EyeLookInLeft")], 0);
    EXPECT_GT(w[at("EyeLookDownRight")], 0);
    EXPECT_GT(w[at("EyeLookUpLeft")], 0);
    const Gaze back = gaze_of(w);
    for (int side : {0, 1}) {
        EXPECT_NEAR(back.yaw[side], gaze.yaw[side], 1e-6f);
        EXPECT_NEAR(back.pitch[side], gaze.pitch[side], 1e-6f);
    }
}

TEST(Synthesis, SpeaksWithTimesThatFitTheSound) {
    if (!can_speak()) {
        EXPECT_EQ(speak("hello").error().code, ErrorCode::unavailable);
        GTEST_SKIP() << "skipped: this build cannot speak";
    }
    const auto said = speak("Hello, my name is Bob.");
    ASSERT_TRUE(said.ok()) << said.error().message;
    EXPECT_EQ(said->sound.sample_rate, 48000);
    EXPECT_EQ(said->sound.channels, 1);
    EXPECT_EQ(said->words.size(), 5u);
    double before = 0;
    int bilabials = 0;
    for (const Phoneme& p : said->phonemes) {
        EXPECT_DOUBLE_EQ(p.start, before);
        before = p.end;
        bilabials += p.ipa == "m" || p.ipa == "b";
    }
    EXPECT_NEAR(before, said->sound.seconds(), 0.001);
    EXPECT_EQ(bilabials, 4);
    // There is a voice where there are sounds, and none in the longest pause.
    const MouthTrack mouth(*said);
    for (const Phoneme& p : said->phonemes)
        if (p.ipa == "aɪ" || p.ipa == "əʊ" || p.ipa == "eɪ") {
            EXPECT_GT(mouth.loudness(0.5 * (p.start + p.end)), 0.2f) << p.ipa;
        }
    EXPECT_EQ(speak("hello", "no-such-voice").error().code, ErrorCode::invalid);
    EXPECT_EQ(speak("...").error().code, ErrorCode::invalid);
}

}  // namespace
}  // namespace mien::samples
