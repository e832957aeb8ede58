#include "encoder/training_take.hpp"

#include "encoder/motion_groups.hpp"

namespace mien::encoder {

namespace {

constexpr int kFewest = 160;       // observations that make a starting chance worth its bits
constexpr int kRounds = 2;         // the second learns from numbers coded with what the first has learnt
constexpr int kBlock = 64;

}  // namespace

coding::MotionBasis basis_for(const TrainingTake& take, coding::MotionScheme scheme) {
    const coding::MotionBasis& from = take.basis;
    coding::MotionBasis basis;
    basis.scheme = scheme;
    basis.step = from.step;
    basis.mean_step = from.mean_step;
    basis.mean = from.mean;
    basis.components = from.components;
    basis.translation_step = from.translation_step;
    basis.rotation_step = from.rotation_step;
    basis.gaze_step = from.gaze_step;
    basis.centre = from.centre;
    basis.side_mean = from.side_mean;
    basis.across_mesh = from.across_mesh;
    basis.mirrored = from.mirrored;
    basis.parents = from.parents;
    basis.level_steps = from.level_steps;
    if (from.scheme == scheme) {
        basis.block = from.block;
        basis.predictors = from.predictors;
        basis.start = from.start;
        return basis;
    }
    basis.block = kBlock;
    const GroupPlan plan{.frames = take.samples.cols(), .group_frames = take.group_frames};
    const bool causal = scheme == coding::MotionScheme::causal;
    if (causal) train_predictors(basis, plan, take.samples);
    coding::MotionShape shape = take.shape();
    shape.presence = false;
    for (int round = 0; round < kRounds; ++round) {
        const GroupOptions options{.whole_bytes = causal, .train = true};
        basis.start = train_start(code_groups(basis, shape, plan, take.samples, {}, options), plan.count(), kFewest);
    }
    return basis;
}

}  // namespace mien::encoder
