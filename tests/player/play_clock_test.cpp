#include "player/play_clock.hpp"

#include <gtest/gtest.h>

namespace mien::player {
namespace {

TEST(PlayClock, StandsUntilItRuns) {
    PlayClock clock;
    clock.set(3);
    EXPECT_EQ(clock.at(100), 3);
    clock.run(100);
    EXPECT_EQ(clock.at(100.5), 3.5);
}

TEST(PlayClock, APauseTakesNoTime) {
    PlayClock clock;
    clock.run(10);
    clock.stop(12);
    EXPECT_EQ(clock.at(50), 2);
    clock.run(50);
    EXPECT_EQ(clock.at(51), 3);
}

TEST(PlayClock, RunningTwiceIsRunningOnce) {
    PlayClock clock;
    clock.run(10);
    clock.run(15);
    EXPECT_EQ(clock.at(20), 10);
}

TEST(PlayClock, ANewRateCountsFromNowOn) {
    PlayClock clock;
    clock.run(0);
    clock.set_rate(2, 0.5);
    EXPECT_DOUBLE_EQ(clock.at(4), 3);
    clock.set_rate(4, 2);
    EXPECT_DOUBLE_EQ(clock.at(5), 5);
}

TEST(PlayClock, WorksSmallDifferencesToTheSoundOffGently) {
    PlayClock clock;
    clock.run(0);
    double now = 1, before = clock.at(now);
    for (int i = 0; i < 200; ++i, now += 0.01) {
        clock.follow(now, now + 0.05);   // sound is 50 ms ahead
        EXPECT_GE(clock.at(now), before) << "never backwards";
        EXPECT_LT(clock.at(now) - before, 0.02) << "never a jump";
        before = clock.at(now);
    }
    EXPECT_NEAR(clock.at(now), now + 0.05, 1e-3);
}

TEST(PlayClock, JumpsWhenTheSoundIsFarAway) {
    PlayClock clock;
    clock.run(0);
    clock.follow(1, 1.5);
    EXPECT_DOUBLE_EQ(clock.at(1), 1.5);
}

TEST(PlayClock, DoesNotFollowWhileItStands) {
    PlayClock clock;
    clock.set(2);
    clock.follow(1, 9);
    EXPECT_EQ(clock.at(1), 2);
}

}  // namespace
}  // namespace mien::player
