#include "bench/bd_rate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::bench {
namespace {

// The two worked examples of JCTVC-E137 (Reliability metric for BD measurements) with their PCHIP delta rates, as Netflix's
// VMAF tests its own calculator by (python/test/bd_rate_calculator_test.py, BDrateCalculatorJCTVCTest).
TEST(BdRate, AgreesWithThePublishedExamples) {
    const RatePoint anchor1[] = {{108048.8736, 43.6471}, {61279.976, 40.3953}, {33905.6656, 37.247}, {18883.6928, 34.2911}};
    const RatePoint test1[] = {{108061.2784, 43.6768}, {61299.9936, 40.4232}, {33928.7472, 37.2761}, {18910.912, 34.3147}};
    EXPECT_NEAR(bd_rate(anchor1, test1).value(), -0.465215420752807, 1e-4);
    const RatePoint anchor2[] = {{40433.8848, 37.5761}, {7622.7456, 35.3756}, {2394.488, 33.8977}, {1017.6184, 32.0603}};
    const RatePoint test2[] = {{40370.12, 37.5982}, {7587.0024, 35.4025}, {2390.0944, 33.9194}, {1017.0984, 32.0822}};
    EXPECT_NEAR(bd_rate(anchor2, test2).value(), -1.8779823450567612, 1e-4);
}

TEST(BdRate, OfAConstantFactorIsThatFactor) {
    const RatePoint anchor[] = {{100, 30}, {190, 33.5}, {420, 36}, {1000, 39}};
    std::vector<RatePoint> test;
    for (const RatePoint& point : anchor) test.push_back({0.7 * point.rate, point.quality});
    EXPECT_NEAR(bd_rate(anchor, test).value(), -30, 1e-9);
    EXPECT_NEAR(bd_rate(test, anchor).value(), 100 / 0.7 - 100, 1e-9);
}

TEST(BdRate, IsTakenWhereBothCurvesAre) {
    // Straight in log rate: a decade per 10 dB, and one that needs 10^0.05 dB-wise more at every dB above 30.
    const RatePoint anchor[] = {{10, 20}, {100, 30}, {1000, 40}};
    const RatePoint test[] = {
        {100, 30}, {100 * std::pow(10, 0.75), 35}, {100 * std::pow(10, 1.5), 40}, {100 * std::pow(10, 3), 50}};
    // The mean of 0.05 (q - 30) over 30 .. 40 is 0.25.
    EXPECT_NEAR(bd_rate(anchor, test).value(), 100 * (std::pow(10, 0.25) - 1), 1e-9);
}

TEST(BdRate, LeavesOutPointsThatAnotherOneBeats) {
    const RatePoint anchor[] = {{100, 30}, {200, 33}, {400, 36}};
    const RatePoint with[] = {{50, 30}, {90, 29}, {100, 33}, {100, 31}, {200, 36}};
    EXPECT_NEAR(bd_rate(anchor, with).value(), -50, 1e-9);
}

TEST(BdRate, IsNothingWithoutACommonRange) {
    const RatePoint low[] = {{10, 20}, {20, 25}}, high[] = {{10, 26}, {20, 30}}, one[] = {{10, 20}};
    EXPECT_FALSE(bd_rate(low, high).has_value());
    EXPECT_FALSE(bd_rate(low, one).has_value());
    EXPECT_FALSE(bd_rate({}, low).has_value());
}

TEST(Pchip, IsExactForLinesAndKeepsMonotoneDataMonotone) {
    const Pchip line({0, 1, 3}, {1, 3, 7});
    EXPECT_DOUBLE_EQ(line.at(2), 5);
    EXPECT_NEAR(line.integral(0.5, 2.5), 8, 1e-12);

    const Pchip step({0, 1, 2, 3, 4}, {0, 0, 1, 1, 5});
    double before = step.at(0);
    for (double x = 0; x <= 4; x += 0.01) {
        EXPECT_GE(step.at(x), before - 1e-12);
        before = step.at(x);
    }
    // Flat where two neighbours are equal, and half-way by symmetry of the Hermite cubic with level ends.
    EXPECT_DOUBLE_EQ(step.at(0.5), 0);
    EXPECT_DOUBLE_EQ(step.at(1.5), 0.5);
}

// Worked by hand from the formulas of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984) on x = 0, 1, 3; y = 0, 1, 2: the
// secants are 1 and 1/2; the inner slope is 9 / (5/1 + 4/0.5) = 9/13 and the end slopes are (4 - 0.5) / 3 = 7/6 and
// (5 * 0.5 - 2) / 3 = 1/6.
TEST(Pchip, HasTheSlopesOfItsSource) {
    const Pchip curve({0, 1, 3}, {0, 1, 2});
    const double h = 1e-6;
    EXPECT_NEAR((curve.at(h) - curve.at(0)) / h, 7.0 / 6, 1e-4);
    EXPECT_NEAR((curve.at(1 + h) - curve.at(1 - h)) / (2 * h), 9.0 / 13, 1e-4);
    EXPECT_NEAR((curve.at(3) - curve.at(3 - h)) / h, 1.0 / 6, 1e-4);
    EXPECT_NEAR(curve.at(2), 1.5 + 2 * (9.0 / 13 - 1.0 / 6) / 8, 1e-12);
}

TEST(Pchip, IntegratesWhatItInterpolates) {
    const Pchip curve({-1, 0, 2, 2.5, 4}, {3, 1, 0.5, -2, -2.5});
    const double from = -0.3, to = 3.7;
    constexpr int kSteps = 200000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += curve.at(from + (to - from) * (i + 0.5) / kSteps);
    EXPECT_NEAR(curve.integral(from, to), sum * (to - from) / kSteps, 1e-8);
}

}  // namespace
}  // namespace mien::bench
