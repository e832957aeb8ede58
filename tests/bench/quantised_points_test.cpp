#include "bench/quantised_points.hpp"

#include <gtest/gtest.h>

#include <random>

#include "bench/short_clip.hpp"

namespace mien::bench {
namespace {

template <class Call>
std::vector<float> both_ways(std::size_t numbers, const Call& call) {
    std::vector<float> fast(numbers), plain(numbers);
    use_plain_arithmetic(false);
    call(fast.data());
    use_plain_arithmetic(true);
    call(plain.data());
    use_plain_arithmetic(false);
    EXPECT_EQ(fast, plain);
    return fast;
}

TEST(DecodedDeltas, OfPaddedPointsAddUpByHand) {
    std::vector<std::int16_t> sums{10, 20, 30, 0, -1, -2, -3, 0};
    const std::int16_t plain[] = {1, -1, 0, 0, 5, 6, 7, 0}, zigzagged[] = {2, 1, 0, 0, 10, 12, 14, 0};
    const std::vector<float> want{5.5f, 9.5f, 15, 2, 2, 2};
    for (const bool zigzag : {false, true})
        EXPECT_EQ(both_ways(6,
                            [&](float* out) {
                                auto mine = sums;
                                add_rows(mine, zigzag ? zigzagged : plain, zigzag, 0.5f, out);
                            }),
                  want);
    EXPECT_EQ(both_ways(6, [&](float* out) { scale_rows(std::span<const std::int16_t>(sums), 0.5f, out); }),
              (std::vector<float>{5, 10, 15, -0.5f, -1, -1.5f}));
}

TEST(DecodedDeltas, OfBytePlanesAddUpByHand) {
    // Zigzag 300 and 299 are 150 and -150: low bytes 44 and 43, then high bytes 1 and 1.
    const std::uint8_t planes16[] = {44, 43, 1, 1}, planes32[] = {44, 43, 1, 1, 0, 0, 0, 0};
    EXPECT_EQ(both_ways(2,
                        [&](float* out) {
                            std::vector<std::int16_t> sums{1, 2};
                            add_planes(sums, planes16, 1, out);
                        }),
              (std::vector<float>{151, -148}));
    EXPECT_EQ(both_ways(2,
                        [&](float* out) {
                            std::vector<std::int32_t> sums{1, 2};
                            add_planes(sums, planes32, 1, out);
                        }),
              (std::vector<float>{151, -148}));
}

TEST(DecodedDeltas, AreTheSameInEveryInstructionSet) {
    std::mt19937 random(7);
    for (const std::size_t count : {4u, 12u, 1000u, 1004u}) {
        std::vector<std::int16_t> rows16(count), sums16(count);
        std::vector<std::int32_t> rows32(count), sums32(count);
        std::vector<std::uint8_t> planes(4 * count);
        for (auto& v : rows16) v = std::int16_t(random());
        for (auto& v : sums16) v = std::int16_t(random());
        for (auto& v : rows32) v = std::int32_t(random());
        for (auto& v : sums32) v = std::int32_t(random());
        for (auto& v : planes) v = std::uint8_t(random());
        for (const bool zigzag : {false, true}) {
            both_ways(count / 4 * 3, [&](float* out) {
                auto s = sums16;
                add_rows(s, rows16.data(), zigzag, 0.1f, out);
            });
            both_ways(count, [&](float* out) {
                auto s = sums32;
                add_rows(s, rows32.data(), zigzag, 0.1f, out);
            });
        }
        both_ways(count, [&](float* out) {
            auto s = sums16;
            add_planes(s, planes.data(), 0.1f, out);
        });
        both_ways(count, [&](float* out) {
            auto s = sums32;
            add_planes(s, planes.data(), 0.1f, out);
        });
    }
}

TEST(QuantisedPoints, LieOnTheGridThatTheAskedErrorMeans) {
    const Clip clip = sheet_clip();
    const GeometryInput input(clip, protocol::MotionKind::vertices);
    const QuantisedPoints points(input, 0.1);
    EXPECT_FLOAT_EQ(points.step, 0.2f);  // three coordinates of step^2 / 12 each
    EXPECT_TRUE(points.narrow);
    for (std::int64_t i = 0; i < points.numbers; ++i) {
        EXPECT_NEAR(float(points.at(5, i)) * points.step, input.frame(5)[i], 0.1001f);
        EXPECT_EQ(points.at(4, i) + points.delta(5, i), points.at(5, i));
    }
    EXPECT_FALSE(QuantisedPoints(input, 0.0001).narrow);
}

}  // namespace
}  // namespace mien::bench
