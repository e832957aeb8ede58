#include "model/contact.hpp"

#include <gtest/gtest.h>

namespace mien::model {
namespace {

/// Two rows of a lip each, 20 vertices 1 mm apart: the upper one at `gap` over the lower one, around y = 5.
struct Lips {
    static constexpr std::uint32_t kLength = 20;
    Points points{2 * kLength, 3};
    Contact contact;

    explicit Lips(float gap, float hold = 1) {
        for (std::uint32_t i = 0; i < kLength; ++i) {
            points.row(i) = Eigen::RowVector3f(float(i), 5 + gap / 2, 90);
            points.row(kLength + i) = Eigen::RowVector3f(float(i), 5 - gap / 2, 90);
            contact.pairs.push_back({i, kLength + i});
            contact.members.push_back({i, hold});
        }
        for (std::uint32_t i = 0; i < kLength; ++i) contact.members.push_back({kLength + i, -hold});
    }
    float gap(std::uint32_t i) const { return points(i, 1) - points(kLength + i, 1); }
};

TEST(Contact, LeavesOpenLipsWhereTheyAre) {
    Lips lips(2 * kContactSoftness + 0.01f);
    const Points before = lips.points;
    hold_apart(lips.contact, lips.points);
    EXPECT_EQ(lips.points, before);
}

TEST(Contact, BringsCrossedLipsToTheMiddleBetweenThem) {
    Lips lips(-1.2f);
    hold_apart(lips.contact, lips.points);
    for (std::uint32_t v = 0; v < 2 * Lips::kLength; ++v) EXPECT_NEAR(lips.points(v, 1), 5, 1e-5f) << v;
}

TEST(Contact, NeverLetsAnyGapEndBelowNothing) {
    for (float gap = -2; gap < 2; gap += 0.01f) {
        Lips lips(gap);
        hold_apart(lips.contact, lips.points);
        EXPECT_GE(lips.gap(7), -1e-5f) << gap;
        EXPECT_GE(lips.gap(7), gap - 1e-5f) << "nothing is pressed together";
    }
}

TEST(Contact, ALiftGrowsWithoutAKink) {
    float last = 0, last_slope = 0;
    for (int i = 0; i <= 400; ++i) {
        Lips lips(1 - 0.005f * float(i));
        hold_apart(lips.contact, lips.points);
        const float height = lips.points(7, 1) - 5, slope = last - height;
        if (i > 1) {
            EXPECT_NEAR(slope, last_slope, 1e-4f) << i;
        }
        last = height, last_slope = slope;
    }
}

TEST(Contact, HalfAHoldTakesHalfThePush) {
    Lips lips(-1.2f, 0.5f);
    hold_apart(lips.contact, lips.points);
    EXPECT_NEAR(lips.points(7, 1), 5 - 0.3f, 1e-5f);
}

TEST(Contact, SlidingLipsMeetOnASurfaceBetweenThem) {
    Lips lips(-0.8f);
    for (std::uint32_t i = 0; i < Lips::kLength; ++i) lips.points(i, 0) += 0.4f;  // the upper one slides
    lips.points.col(1) += 0.1f * lips.points.col(0);                              // on a slope
    hold_apart(lips.contact, lips.points);
    for (std::uint32_t i = 3; i + 3 < Lips::kLength; ++i) {
        const float upper_at_lower = lips.points(i, 1) - 0.04f;  // the slope between the two
        EXPECT_NEAR(upper_at_lower, lips.points(Lips::kLength + i, 1), 0.02f) << i;
    }
}

TEST(Contact, OfNobodyMovesNothing) {
    Lips lips(-1);
    const Points before = lips.points;
    hold_apart({}, lips.points);
    EXPECT_EQ(lips.points, before);
}

}  // namespace
}  // namespace mien::model
