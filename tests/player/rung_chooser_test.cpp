#include "player/rung_chooser.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::player {
namespace {

const std::vector<double> kNeeds{100e3, 300e3, 1000e3};   // bit/s

/// A line and a server that sends up to `ahead` seconds before they are due, in steps of a fifth of a second.
struct Simulation {
    RungChooser chooser;
    double now = 1000, buffer = 0, ahead = 5;
    std::size_t changes = 0;

    explicit Simulation(std::size_t first) : chooser(kNeeds, first) {}

    /// `line`: bit/s. `measured`: whether the player knows it.
    std::size_t play(double seconds, double line, bool measured = true) {
        for (const double end = now + seconds; now < end; now += 0.2) {
            const double need = kNeeds[chooser.rung()];
            buffer = std::clamp(buffer - 0.2 + 0.2 * line / need, 0.0, ahead);
            const std::size_t before = chooser.rung();
            chooser.choose(now, {buffer, measured ? std::optional(line) : std::nullopt});
            changes += chooser.rung() != before;
        }
        return chooser.rung();
    }
    std::size_t play_until_change(double line) {
        const std::size_t before = changes;
        const double begun = now;
        while (changes == before && now < begun + 100) play(0.1, line);
        return chooser.rung();
    }
};

TEST(RungChooser, AFastLineClimbsToTheTopOneRungAtATime) {
    Simulation s(0);
    EXPECT_EQ(s.play_until_change(50e6), 1u);
    EXPECT_GE(s.now, 1000 + RungChooser::kHold);
    EXPECT_EQ(s.play_until_change(50e6), 2u);
    EXPECT_EQ(s.play(60, 50e6), 2u);
    EXPECT_EQ(s.changes, 2u);
}

TEST(RungChooser, ClimbsToWhatALineTakesEasilyAndStaysThere) {
    Simulation s(0);
    EXPECT_EQ(s.play(300, 900e3), 1u) << "1000 kbit/s do not fit 900";
    EXPECT_EQ(s.changes, 1u);
    EXPECT_EQ(s.play(300, 1200e3), 1u) << "they would fill 1200, but a little less and the picture stands";
    EXPECT_EQ(s.play(300, 1500e3), 2u);
}

TEST(RungChooser, ALineThatBecomesSlowCostsTheFinestRungBeforeThePictureStands) {
    Simulation s(2);
    s.play(10, 50e6);
    EXPECT_EQ(s.play_until_change(450e3), 1u) << "300 of 450 fit";
    EXPECT_GT(s.buffer, 1) << "seconds are left";
    s.play(60, 450e3);
    EXPECT_EQ(s.chooser.rung(), 1u);
    EXPECT_GT(s.buffer, 4);
    EXPECT_EQ(s.play_until_change(120e3), 0u);
    EXPECT_GT(s.buffer, 0);
}

TEST(RungChooser, WhenNearlyNothingIsLeftItGoesToTheCoarsestWhateverWasMeasured) {
    Simulation s(2);
    s.play(10, 50e6);
    s.play(6, 0, false);   // nothing comes, so nothing can be measured
    EXPECT_EQ(s.chooser.rung(), 0u);
}

TEST(RungChooser, TheStartAndASeekAreNotAStarvedLine) {
    Simulation s(2);
    s.buffer = 0;
    EXPECT_EQ(s.chooser.choose(s.now, {0, 50e6}), 2u);
    EXPECT_EQ(s.chooser.choose(s.now += 0.2, {0, std::nullopt}), 2u);
    s.play(10, 50e6);
    s.chooser.refill();
    s.buffer = 0;
    EXPECT_EQ(s.chooser.choose(s.now += 0.2, {0, 50e6}), 2u);
    EXPECT_EQ(s.chooser.choose(s.now += 0.2, {0.3, std::nullopt}), 2u);
    EXPECT_EQ(s.play(10, 50e6), 2u);
    // But a line that is known to be too slow is, at once.
    EXPECT_EQ(RungChooser(kNeeds, 2).choose(0, {0, 400e3}), 1u);
}

TEST(RungChooser, ARungThatDoesNotHoldIsTriedLessAndLessOften) {
    // The line cannot be measured and takes 500 kbit/s: the finest rung never holds.
    Simulation s(1);
    s.play(20, 500e3, false);
    const std::size_t early = s.changes;
    EXPECT_GE(early, 2u) << "it was tried";
    s.play(600, 500e3, false);
    EXPECT_LE(s.changes - early, 45u);
    Simulation steady(1);
    steady.play(600, 500e3);   // measured, it is not tried at all
    EXPECT_EQ(steady.changes, 0u);
}

TEST(RungChooser, TwiceTheSpeedNeedsTwiceTheLine) {
    RungChooser chooser(kNeeds, 1);
    EXPECT_EQ(chooser.choose(0, {0, 500e3}, 1), 1u);
    EXPECT_EQ(chooser.choose(1, {0, 500e3}, 2), 0u);
}

TEST(RungChooser, RatesThatNobodyKnowsAreGoneByTheBufferAlone) {
    RungChooser chooser({0, 0}, 0);
    double now = 0;
    for (; now < 10; now += 0.2) chooser.choose(now, {5, 1e3});
    EXPECT_EQ(chooser.rung(), 1u);
    EXPECT_EQ(chooser.choose(now, {0.1, 1e3}), 0u);
}

}  // namespace
}  // namespace mien::player
