#include "encoder/training_take.hpp"

#include <algorithm>
#include <cmath>

#include "encoder/motion_groups.hpp"

namespace mien::encoder {

namespace {

constexpr int kFewest = 160;       // observations that make a starting chance worth its bits
constexpr int kRounds = 2;         // the second learns from numbers coded with what the first has learnt
constexpr int kBlock = 64;
constexpr std::array<std::int16_t, coding::MotionBasis::kMaxOrder> kHeadGoesOn{384, -128, 0};   // half as fast as it went

}  // namespace

void add_pose(TrainingTake& take, PointsRef reference) {
    if (take.info.has_pose) return;
    coding::MotionBasis& basis = take.basis;
    const Vec3 centre = reference.colwise().mean();
    const double radius = std::max(1.0, std::sqrt(double((reference.rowwise() - centre.transpose()).rowwise().squaredNorm().mean())));
    // The error that the take was coded for, as the encoder's first step follows from it.
    const double error = basis.step / std::sqrt(12.0 * double(take.info.count) / double(std::clamp<std::uint32_t>(basis.size(), 4, 24)));
    basis.translation_step = float(0.6 * error);
    basis.rotation_step = float(0.6 * error / radius);
    for (int i = 0; i < 3; ++i) basis.centre[std::size_t(i)] = centre[i];
    std::copy_backward(basis.side_mean.begin(), basis.side_mean.begin() + 4, basis.side_mean.end());   // of gaze
    std::fill_n(basis.side_mean.begin(), 6, 0);
    // Contexts are numbered as if there had always been a pose, so the starting chances stay what they are.
    if (!basis.predictors.empty()) basis.predictors.insert(basis.predictors.begin(), 6, kHeadGoesOn);
    Eigen::MatrixXd samples = Eigen::MatrixXd::Zero(take.samples.rows() + 6, take.samples.cols());
    samples.bottomRows(take.samples.rows()) = take.samples;
    take.samples = std::move(samples);
    take.info.has_pose = true;
}

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
    if (causal && take.info.has_pose && take.samples.topRows(6).isZero()) std::fill_n(basis.predictors.begin(), 6, kHeadGoesOn);
    coding::MotionShape shape = take.shape();
    shape.presence = false;
    for (int round = 0; round < kRounds; ++round) {
        const GroupOptions options{.whole_bytes = causal, .train = true};
        basis.start = train_start(code_groups(basis, shape, plan, take.samples, {}, options), plan.count(), kFewest);
    }
    return basis;
}

}  // namespace mien::encoder
