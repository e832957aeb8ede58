#include "render/bust.hpp"

#include <gtest/gtest.h>

#include "test_models.hpp"

namespace mien::render {
namespace {

TEST(BustFade, LiesBelowTheChinAndEndsAtTheCut) {
    const Mesh bust = make_bust(-190);
    const auto fade = bust_fade(bust);
    ASSERT_TRUE(fade);
    EXPECT_FLOAT_EQ(fade->gone, -190);
    EXPECT_GT(fade->whole, fade->gone + 20);
    EXPECT_LT(fade->whole, -130) << "a chin lies within two eye distances of 63 mm below the eyes";
}

TEST(BustFade, LeavesMasksAndEyelessMeshesWhole) {
    EXPECT_FALSE(bust_fade(make_bust(-120)));
    EXPECT_FALSE(bust_fade(make_card(400)));
    EXPECT_FALSE(bust_fade(Mesh{}));
}

}  // namespace
}  // namespace mien::render
