#include "tools/motion_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace mien::tools {
namespace {

TEST(StillRms, IsThatOfThePointsAboutTheirOwnMeans) {
    // Two frames of two points: one stands still far out, one goes 6 mm in x and 8 in y.
    const std::vector<float> values{1000, 0, 0, 1, 2, 3, 1000, 0, 0, 7, 10, 3};
    EXPECT_NEAR(still_rms(values, 2, 3), std::sqrt((5 * 5 + 5 * 5) / 4.0), 1e-9);
}

TEST(StillRms, LeavesOutWhatIsAbsent) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NEAR(still_rms({nan, 1, 5, nan, 3, 5}, 3, 1), std::sqrt(2 / 4.0), 1e-9);
    EXPECT_EQ(still_rms({nan, nan}, 1, 1), 0);
    EXPECT_EQ(still_rms({}, 4, 3), 0);
}

}  // namespace
}  // namespace mien::tools
