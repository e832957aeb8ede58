#include "core/frame_rate.hpp"

#include <gtest/gtest.h>

namespace mien {
namespace {

TEST(FrameRate, IsBounded) {
    for (const char* text : {"0.01", "1/100", "29.97", "1000"}) EXPECT_TRUE(parse_frame_rate(text).ok()) << text;
    for (const char* text : {"1000000000", "1001", "0.009", "1/101", "abc"}) {
        const auto rate = parse_frame_rate(text);
        ASSERT_FALSE(rate.ok()) << text;
        EXPECT_EQ(rate.error().message, "must be frames per second, from 0.01 to 1000, as 30, 29.97 or 30000/1001");
    }
    EXPECT_TRUE(parse_rational("1000000000").ok()) << "a time base may be as fine as that";
}

}  // namespace
}  // namespace mien
