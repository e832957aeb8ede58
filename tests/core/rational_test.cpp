#include "core/rational.hpp"

#include <gtest/gtest.h>

namespace mien {
namespace {

TEST(Rational, ParsesWholeDecimalAndFraction) {
    EXPECT_EQ(*parse_rational("30"), (Rational{30, 1}));
    EXPECT_EQ(*parse_rational("30000/1001"), (Rational{30000, 1001}));
    EXPECT_EQ(*parse_rational("30000:1001"), (Rational{30000, 1001}));
    EXPECT_EQ(*parse_rational("29.97"), (Rational{2997, 100}));
    EXPECT_EQ(*parse_rational("60.0"), (Rational{60, 1}));
}

TEST(Rational, RefusesWhatIsNoPositiveRate) {
    for (const char* text : {"", "0", "-30", "30/0", "/", "1e3", "30 ", "nan", "99999999999", "30/-1", "."})
        EXPECT_FALSE(parse_rational(text).ok()) << text;
}

TEST(Rational, RescaleRoundsToNearest) {
    EXPECT_EQ(rescale(1, {1, 30}, {1, 48000}), 1600);
    EXPECT_EQ(rescale(1, {1001, 30000}, {1, 48000}), 1602);   // 1601.6
    EXPECT_EQ(rescale(-1, {1001, 30000}, {1, 48000}), -1602);
    EXPECT_EQ(rescale(std::int64_t(1) << 50, {1, 48000}, {1, 48000}), std::int64_t(1) << 50);
}

}  // namespace
}  // namespace mien
