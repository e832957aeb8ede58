#include <gtest/gtest.h>

#include "bench/synthesis_run.hpp"
#include "tests/detail/small_model.hpp"

namespace mien::bench {
namespace {

TEST(SynthesisTest, EveryLayerIsTimedBesideReadingItAndBothWaysAgree) {
    SmallModel small;
    model::FaceModel face;
    face.neutral = small.model.neutral;
    const std::size_t medium = small.model.medium.planes.size(), fine = small.model.fine.planes.size();
    face.detail = std::make_shared<model::DetailLayers>(small.model);
    const auto times = time_synthesis(face, 3);
    ASSERT_TRUE(times.ok());
    EXPECT_EQ(times->markers, std::int64_t(small.model.sites.size()));
    EXPECT_EQ(times->medium_side, 32);
    EXPECT_EQ(times->fine_side, 48);
    std::vector<std::string> names;
    for (const auto& row : times->rows) {
        names.push_back(row.name);
        EXPECT_GT(row.read, 0);
        EXPECT_GT(row.fast, 0);
        EXPECT_GT(row.ratio, 0);
        EXPECT_LT(row.difference, 1e-4) << row.name;
    }
    EXPECT_EQ(names, (std::vector<std::string>{"medium", "fine", "medium + fine", "albedo"}));
    EXPECT_EQ(times->rows[2].bytes, 4 * (medium + fine));
}

TEST(SynthesisTest, AModelWithoutDetailIsRefused) {
    const auto times = time_synthesis(model::FaceModel{}, 1);
    ASSERT_FALSE(times.ok());
    EXPECT_EQ(times.error().code, ErrorCode::invalid);
}

}  // namespace
}  // namespace mien::bench
