#include <gtest/gtest.h>

#include <cstdio>

#include "encoder/motion_encoder.hpp"
#include "object_walk.hpp"
#include "samples/markers.hpp"
#include "samples/performance.hpp"
#include "samples/procedural_actor.hpp"

namespace mien {
namespace {

using encoder::MotionPreset;

Clip head_markers(std::int64_t first, std::int64_t frames) {
    const auto actor = samples::make_procedural_actor(1);
    const auto sites = samples::place_markers(*actor, 60);
    const samples::Performance performance = samples::perform_expressions({30, 1}, 0, 1);
    Clip clip;
    clip.markers.emplace(frames, Eigen::Index(sites.size()));
    for (std::int64_t f = 0; f < frames; ++f) {
        const samples::Instant& instant = performance.instants[std::size_t(first + f)];
        const Points skin = actor->deform(instant);
        for (std::size_t m = 0; m < sites.size(); ++m)
            clip.markers->frame(f).row(Eigen::Index(m)) = sites[m].position(skin).transpose();
        apply_pose(instant.head, clip.markers->frame(f));
    }
    return clip;
}

// What tests/coding holds for sources of known shape, for the decisions that a head makes.
TEST(CodeLength, OfAHeadsMotionIsItsModelsLogLoss) {
    const Clip clip = head_markers(60, 90);
    for (const MotionPreset preset : {MotionPreset::file, MotionPreset::live}) {
        const auto motion = encoder::encode_motion(clip, {.kind = protocol::MotionKind::markers, .preset = preset, .rms = 0.02});
        ASSERT_TRUE(motion.ok()) << motion.error().message;
        const coding::MotionShape shape{.points = motion->info.count, .pose = motion->info.has_pose, .presence = motion->info.has_presence};
        const auto basis = coding::read_motion_basis(shape, motion->basis, {});
        ASSERT_TRUE(basis.ok()) << basis.error().message;
        motion_test::ObjectWalk walk(*basis, shape);
        double real = 0, ideal = 0, objects = 0;
        for (const protocol::Group& group : motion->groups) {
            walk.begin_group();
            for (const protocol::Object& object : group.objects) {
                coding::MeteredDecoder coder(object.bytes);
                walk.decode(coder, object.frames);
                ASSERT_TRUE(coder.complete());
                const double bits = 8.0 * double(object.bytes.size()), loss = coder.bits(true) + coder.bits(false);
                EXPECT_LE(bits, loss * 1.001 + 8);
                real += bits;
                ideal += loss;
                ++objects;
            }
        }
        std::printf("%s: %.0f objects of %.1f bits, %.2f above their log-loss\n", preset == MotionPreset::file ? "file" : "live", objects,
                    real / objects, (real - ideal) / objects);
        EXPECT_GT(ideal, 2000) << "so few bits prove nothing";
        EXPECT_GE(real, ideal - 16 * objects);
    }
}

}  // namespace
}  // namespace mien
