#include "net/line_meter.hpp"

#include <gtest/gtest.h>

namespace mien::net {
namespace {

TEST(LineMeter, TellsTheRateOfALineThatIsNeverIdle) {
    LineMeter meter;
    double now = 50;
    EXPECT_FALSE(meter.bits_per_second(now));
    for (int i = 0; i < 200; ++i) meter.arrived(now += 0.02, 1000);   // 50 kB/s
    EXPECT_NEAR(*meter.bits_per_second(now), 400e3, 1e3);
}

TEST(LineMeter, ASendersOwnPausesAreNotTheLines) {
    LineMeter meter;
    double now = 50;
    for (int group = 0; group < 4; ++group, now += 0.8)
        for (int i = 0; i < 20; ++i) meter.arrived(now += 0.01, 5000);   // 500 kB/s for a fifth of a second, once a second
    EXPECT_NEAR(*meter.bits_per_second(now), 4e6, 1e4);
}

TEST(LineMeter, ALineThatHasBecomeSlowIsNotPraisedForWhatItTookBefore) {
    LineMeter meter;
    double now = 50;
    for (int i = 0; i < 100; ++i) meter.arrived(now += 0.0001, 50000);
    EXPECT_GT(*meter.bits_per_second(now), 1e9);
    for (int i = 0; i < 50; ++i) meter.arrived(now += 0.02, 1000);
    EXPECT_NEAR(*meter.bits_per_second(now), 400e3, 20e3);
}

TEST(LineMeter, LittleOrOldBytesSayNothing) {
    LineMeter meter;
    double now = 50;
    for (int i = 0; i < 10; ++i) meter.arrived(now += 0.001, 500);
    EXPECT_FALSE(meter.bits_per_second(now));
    for (int i = 0; i < 100; ++i) meter.arrived(now += 0.001, 500);
    EXPECT_TRUE(meter.bits_per_second(now));
    EXPECT_FALSE(meter.bits_per_second(now + LineMeter::kWindow + 1));
    meter.interrupted();
    meter.arrived(now + LineMeter::kWindow + 1, 1u << 20);
    EXPECT_FALSE(meter.bits_per_second(now + LineMeter::kWindow + 1)) << "the first after a pause of ours";
}

}  // namespace
}  // namespace mien::net
