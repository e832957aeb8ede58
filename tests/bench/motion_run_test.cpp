#include "bench/motion_run.hpp"

#include <gtest/gtest.h>

#include "bench/short_clip.hpp"
#include "core/parallel.hpp"

namespace mien::bench {
namespace {

TEST(MotionRun, KnownFramesWeighWhatTheyDidInTraining) {
    const Clip clip = sheet_clip();
    encoder::MotionOptions options;
    options.preset = encoder::MotionPreset::live;
    options.group_frames = 5;
    const auto times = time_motion(clip, options, 1000, 2);
    ASSERT_TRUE(times.ok()) << times.error().message;
    EXPECT_EQ(times->frames, clip.vertices->frames);
    EXPECT_EQ(times->points, clip.vertices->points);
    EXPECT_EQ(times->known_frames, times->frames);   // there are no more
    EXPECT_GT(times->components, 0);
    EXPECT_LE(times->rms, 0.1);
    // Coded one by one they weigh what they did in training, where all of them together were to keep the error.
    EXPECT_NEAR(double(times->known_bytes), double(times->frame_bytes), 0.1 * double(times->frame_bytes));
    EXPECT_LT(times->known_rms, 0.15);
    EXPECT_GT(times->known, 0);
    EXPECT_GE(times->decisions, times->frames);
    EXPECT_GT(times->decision, 0);
    EXPECT_EQ(thread_count(), times->threads);
}

}  // namespace
}  // namespace mien::bench
