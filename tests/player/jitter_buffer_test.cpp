#include "player/jitter_buffer.hpp"

#include <gtest/gtest.h>

namespace mien::player {
namespace {

void fill(JitterBuffer& buffer, std::int64_t first, std::int64_t end) {
    for (std::int64_t f = first; f < end; ++f) buffer.push({f, {}, std::nullopt});
}

TEST(JitterBuffer, GivesTheFrameThatIsDue) {
    JitterBuffer buffer(8, 2);
    fill(buffer, 0, 4);
    EXPECT_EQ(buffer.take(0)->frame, 0);
    EXPECT_EQ(buffer.take(0), std::nullopt) << "frame 1 is still to come";
    EXPECT_EQ(buffer.take(1)->frame, 1);
    EXPECT_EQ(buffer.dropped(), 0u);
}

TEST(JitterBuffer, DropsWhatCameTooLate) {
    JitterBuffer buffer(8, 2);
    fill(buffer, 0, 6);
    EXPECT_EQ(buffer.take(4)->frame, 4);
    EXPECT_EQ(buffer.dropped(), 4u);
    EXPECT_EQ(buffer.take(100)->frame, 5);
    EXPECT_EQ(buffer.dropped(), 4u) << "the last one was shown";
}

TEST(JitterBuffer, JumpsOverAGapOnlyWhenItIsPast) {
    JitterBuffer buffer(8, 1);
    fill(buffer, 0, 1);
    fill(buffer, 5, 7);   // 1 .. 4 were damaged
    EXPECT_EQ(buffer.take(3)->frame, 0);
    EXPECT_EQ(buffer.take(4), std::nullopt);
    EXPECT_EQ(buffer.take(5)->frame, 5);
    EXPECT_EQ(buffer.dropped(), 0u);
}

TEST(JitterBuffer, IsReadyWithEnoughOrWithAllThereIs) {
    JitterBuffer buffer(8, 3);
    fill(buffer, 0, 2);
    EXPECT_FALSE(buffer.ready());
    buffer.finish();
    EXPECT_TRUE(buffer.ready());
    JitterBuffer other(8, 3);
    fill(other, 0, 3);
    EXPECT_TRUE(other.ready());
}

TEST(JitterBuffer, EnoughIsNeverMoreThanItHolds) {
    JitterBuffer buffer(2, 30);
    fill(buffer, 0, 2);
    EXPECT_FALSE(buffer.has_room());
    EXPECT_TRUE(buffer.ready()) << "or playing would never start";
}

TEST(JitterBuffer, IsDrainedOnlyAfterTheLastFrameWasTaken) {
    JitterBuffer buffer(4, 1);
    fill(buffer, 0, 1);
    buffer.finish();
    EXPECT_FALSE(buffer.drained());
    EXPECT_EQ(buffer.pop()->frame, 0);
    EXPECT_TRUE(buffer.drained());
    EXPECT_EQ(buffer.pop(), std::nullopt);
}

TEST(JitterBuffer, ASeekBeginsAnew) {
    JitterBuffer buffer(4, 1);
    fill(buffer, 10, 12);
    buffer.finish();
    buffer.clear();
    EXPECT_TRUE(buffer.empty());
    EXPECT_FALSE(buffer.drained());
    fill(buffer, 3, 4);   // earlier than before
    EXPECT_EQ(buffer.first(), 3);
}

}  // namespace
}  // namespace mien::player
