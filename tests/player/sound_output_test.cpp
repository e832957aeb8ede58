#include "player/sound_output.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "player/live_sound.hpp"

namespace mien::player {
namespace {

using namespace std::chrono_literals;

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

constexpr int kRate = 48000;
constexpr double kQueue = 0.2;    // seconds of sound that the device may hold at most
constexpr double kAhead = 0.1;    // the null device mixes this much before it is heard, and says so in steps

Sound quiet(double seconds) { return {kRate, 1, std::vector<float>(std::size_t(seconds * kRate), 0.01f)}; }

/// On OpenAL Soft's device that makes no sound but takes its time as a real one does.
class SoundOutputTest : public testing::Test {
protected:
    void SetUp() override {
        ::setenv("ALSOFT_DRIVERS", "null", 1);
        std::string why;
        sound_ = SoundOutput::open(kRate, &why);
        ASSERT_NE(sound_, nullptr) << why;
    }
    void push(double at, double seconds) { sound_->push(std::llround(at * kRate), quiet(seconds)); }
    /// Waits for the first time that is heard, or for silence.
    std::optional<double> wait_heard(bool sounds) {
        for (const double end = now() + 20; now() < end; std::this_thread::sleep_for(1ms))
            if (const auto heard = sound_->heard(); heard.has_value() == sounds) return heard;
        ADD_FAILURE() << (sounds ? "nothing is heard" : "the sound does not end");
        return {};
    }
    void expect_heard_from(double media) {
        const double begun = now();
        sound_->play();
        const auto heard = wait_heard(true);
        ASSERT_TRUE(heard);
        // Time is not asserted: what is heard cannot be further than the time that has gone by since it began.
        EXPECT_LE(*heard, media + (now() - begun) + kAhead);
        EXPECT_GE(*heard, media - kAhead);
    }

    std::unique_ptr<SoundOutput> sound_;
};

TEST_F(SoundOutputTest, ASeekIsHeardFromWhereItGoesHoweverLongItWaits) {
    push(0, 1);
    expect_heard_from(0);
    for (const double target : {7.0, 2.0}) {
        sound_->pause();
        sound_->flush(target);
        push(target, 3);
        std::this_thread::sleep_for(150ms);   // for the picture
        EXPECT_GE(sound_->buffered(), 3 - kQueue - 1e-6) << "what was not heard is still there";
        expect_heard_from(target);
    }
}

TEST_F(SoundOutputTest, SoundThatComesAfterItRanDryAndWasPausedIsKept) {
    push(0, 0.1);
    sound_->play();
    wait_heard(true);
    wait_heard(false);
    sound_->pause();
    push(0.1, 3);
    std::this_thread::sleep_for(150ms);
    EXPECT_GE(sound_->buffered(), 3 - kQueue - 1e-6);
    expect_heard_from(0.1);
}

TEST_F(SoundOutputTest, GoesOnByItselfAfterRunningDry) {
    push(0, 0.1);
    sound_->play();
    wait_heard(true);
    wait_heard(false);
    const double begun = now();
    push(0.1, 1);
    const auto heard = wait_heard(true);
    ASSERT_TRUE(heard);
    EXPECT_LE(*heard, 0.1 + (now() - begun) + kAhead);
}

TEST_F(SoundOutputTest, LiveSoundBeginsWithTheLastOfABacklogAndWithTheNewestAfterABreak) {
    LiveSound live(*sound_);
    const auto add = [&](double at, double came) { live.add({std::llround(at * kRate), quiet(0.01)}, came); };
    const double joined = now();
    for (int b = 0; b < 100; ++b) add(b * 0.01, joined);   // the group that is under way, at once
    double at = 1;
    const auto go_on = [&](int blocks) {
        std::optional<double> first;
        for (int b = 0; b < blocks; ++b, at += 0.01) {
            std::this_thread::sleep_for(10ms);
            add(at, now());
            if (!first) first = sound_->heard();
        }
        return first;
    };
    const auto first = go_on(80);
    ASSERT_TRUE(first);
    EXPECT_GE(*first, 0.95 - kAhead);
    EXPECT_LE(*first, at);
    at = 7;   // the sender was away, or a pause
    go_on(80);
    const auto after = wait_heard(true);
    ASSERT_TRUE(after);
    EXPECT_GE(*after, 7 - kAhead);
}

}  // namespace
}  // namespace mien::player
