#include <gtest/gtest.h>

#include <cmath>

#include "samples/performance_training.hpp"
#include "samples/procedural_actor.hpp"
#include "samples/stage_scans.hpp"

namespace mien::samples {
namespace {

TEST(Folds, BuckleOnlyPastTheirThresholdAndWithItsSquareRoot) {
    EXPECT_EQ(fold_depth(0.04f, 0.05f), 0);
    EXPECT_NEAR(fold_depth(0.054f, 0.05f) / fold_depth(0.051f, 0.05f), 2, 0.1f) << "four times as far past it is twice as deep";
    EXPECT_LT(fold_depth(2, 0.05f), 1);
}

TEST(Folds, AreGroovesBetweenRidgesThatSharpen) {
    EXPECT_NEAR(fold_profile(0, 1, 0.5f), -1, 0.01f);
    EXPECT_GT(fold_profile(1.9f, 1, 0), 0.3f);
    EXPECT_NEAR(fold_profile(6, 1, 0), 0, 1e-3f);
    EXPECT_GT(fold_profile(0.5f, 1, 1), fold_profile(0.5f, 1, 0.1f)) << "a crease is narrower";
}

TEST(Stretch, IsTheLogarithmOfTheStretchInEveryDirection) {
    const auto actor = make_procedural_actor(0);
    const Mesh& mesh = actor->neutral();
    Points moved = 1.1f * mesh.positions;
    const Stretch::Field even = Stretch(mesh).at(moved);
    const auto surfaces = mesh.triangle_surfaces();
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 97) {
        if (surfaces[t] != Surface::skin) continue;
        const std::uint32_t v = mesh.triangles[t][0];
        EXPECT_NEAR(even(v, 0) + even(v, 1) + even(v, 2), 2 * std::log(1.1f), 2e-3f);
    }
    apply_pose({Eigen::Quaternionf(Eigen::AngleAxisf(0.4f, Vec3::UnitX())), Vec3(9, 1, 2)}, moved = mesh.positions);
    EXPECT_LT(Stretch(mesh).at(moved).cwiseAbs().maxCoeff(), 2e-3f) << "turned, not stretched";
}

TEST(StageScans, ShowTheMeshAtRestAndWrinklesUnderRaisedBrows) {
    const std::shared_ptr<const Actor> actor = make_procedural_actor(0);
    const TrainingSession session = perform_training(2, 0, 0);
    ASSERT_EQ(session.takes.size(), 6u);
    const StageScans scans(actor, session.performance.instants, {.medium_size = 64, .fine_size = 128});
    auto rest = scans.read(0), raised = scans.read(1);
    ASSERT_TRUE(rest.ok() && raised.ok());
    const TexelMap texels = make_texel_map(actor->neutral(), 64, 64, 1u << int(Surface::skin));
    const Points deformed = actor->deform(session.performance.instants[0]);
    int seen = 0;
    for (std::size_t i = 0; i < texels.texels.size(); ++i) {
        const Vec3 p = Eigen::Map<const Vec3>(rest->medium.values.data() + 3 * i);
        if (!p.allFinite()) continue;
        ++seen;
        const Triangle& c = actor->neutral().triangles[texels.texels[i].triangle];
        const Site site{{c[0], c[1], c[2]}, {1 - texels.texels[i].b1 - texels.texels[i].b2, texels.texels[i].b1, texels.texels[i].b2}};
        EXPECT_LT((site.position(deformed) - p).norm(), 1e-3f);
    }
    EXPECT_GT(seen, 500);
    const SkinRelief relief(*actor, make_texel_map(actor->neutral(), 256, 256, 1u << int(Surface::skin)), 0);
    const auto depth = [&](const Instant& instant) {
        const FloatMap map = relief.fine(relief.stretch().at(actor->deform(instant)));
        float deepest = 0;
        for (const float h : map.values) deepest = std::min(deepest, h);
        return -deepest;
    };
    EXPECT_LT(depth(session.performance.instants[0]), 0.06f) << "pores alone";
    EXPECT_GT(depth(session.performance.instants[1]), 0.1f);
    EXPECT_LT(depth(session.performance.instants[1]), 0.8f);
}

TEST(StageScans, HaveNoiseAndHolesWhenAsked) {
    const std::shared_ptr<const Actor> actor = make_procedural_actor(0);
    const std::vector<Instant> rest(2);
    const StageScans clean(actor, rest, {.medium_size = 64, .fine_size = 64, .albedo = false});
    const StageScans worn(actor, rest, {.medium_size = 64, .fine_size = 64, .albedo = false, .noise = 0.2, .holes = 0.3});
    double squares = 0, both = 0, lost = 0, all = 0;
    auto a = clean.read(1), b = worn.read(1);
    for (std::size_t i = 0; i < a->medium.values.size(); ++i) {
        if (!std::isfinite(a->medium.values[i])) continue;
        ++all;
        if (!std::isfinite(b->medium.values[i])) ++lost;
        else squares += std::pow(double(a->medium.values[i] - b->medium.values[i]), 2), ++both;
    }
    EXPECT_NEAR(std::sqrt(squares / both), 0.2, 0.02);
    EXPECT_NEAR(lost / all, 0.3, 0.12);
    EXPECT_FALSE(worn.read(2).ok());
}

}  // namespace
}  // namespace mien::samples
