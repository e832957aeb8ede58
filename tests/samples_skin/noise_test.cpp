#include "samples/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::samples {
namespace {

TEST(Noise, IsAFunctionOfPlaceAndSeedAlone) {
    const Vec3 p(3.7f, -12.2f, 0.4f);
    EXPECT_EQ(gradient_noise(p, 5), gradient_noise(p, 5));
    EXPECT_NE(gradient_noise(p, 5), gradient_noise(p, 6));
    EXPECT_EQ(cellular_noise(p, 5).id, cellular_noise(p, 5).id);
}

TEST(Noise, GradientNoiseIsZeroOnTheLatticeAndCentredOffIt) {
    for (int i = -3; i < 3; ++i) EXPECT_FLOAT_EQ(gradient_noise(Vec3(float(i), float(2 * i), 7), 1), 0);
    Random random(1);
    double sum = 0, square = 0;
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) {
        const float n = fractal_noise(
            Vec3(random.uniform(-50, 50), random.uniform(-50, 50), random.uniform(-50, 50)), 3, 9);
        EXPECT_LT(std::abs(n), 1.2f);
        sum += n;
        square += n * n;
    }
    EXPECT_NEAR(sum / kCount, 0, 0.01);
    EXPECT_GT(square / kCount, 0.01);  // and it is no flat zero
}

TEST(Noise, GradientNoiseIsContinuousAcrossCells) {
    for (const float y : {0.13f, 2.6f, -7.4f}) {
        const float before = gradient_noise(Vec3(1.99999f, y, 0.3f), 3),
                    after = gradient_noise(Vec3(2.00001f, y, 0.3f), 3);
        EXPECT_NEAR(before, after, 1e-3f);
    }
}

TEST(Noise, CellularDistancesAreOrderedAndReachNoFartherThanACellAllows) {
    Random random(2);
    for (int i = 0; i < 2000; ++i) {
        const Cellular c =
            cellular_noise(Vec3(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)), 4);
        EXPECT_LE(c.nearest, c.second);
        EXPECT_LE(c.nearest, std::sqrt(3.0f));
    }
}

TEST(Noise, RandomNumbersHaveTheMomentsTheyPromise) {
    Random random(3);
    double uniform = 0, normal = 0, square = 0;
    constexpr int kCount = 50000;
    for (int i = 0; i < kCount; ++i) {
        const float u = random.uniform();
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
        uniform += u;
        const float n = random.normal();
        normal += n;
        square += n * n;
    }
    EXPECT_NEAR(uniform / kCount, 0.5, 0.01);
    EXPECT_NEAR(normal / kCount, 0, 0.02);
    EXPECT_NEAR(square / kCount, 1, 0.03);
}

}  // namespace
}  // namespace mien::samples
