#include "encoder/motion_encoder.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "coding/motion_values.hpp"
#include "encoder/motion_goal.hpp"
#include "encoder/motion_matrix.hpp"
#include "encoder/motion_peaks.hpp"
#include "encoder/motion_pose.hpp"
#include "encoder/motion_search.hpp"
#include "encoder/reference_points.hpp"
#include "encoder/trained_motion.hpp"
#include "protocol/limits.hpp"

namespace mien::encoder {
namespace {

using coding::MotionBasis;
using coding::MotionScheme;
using protocol::MotionKind;

constexpr int kMostComponents = 320;
constexpr double kNearlyStill = 10;   // errors that the head strays: up to here no pose at all may be cheaper

// How far poses move the points apart from their mean place, RMS in mm: below what counts, there is no pose to send.
double pose_spread(const std::vector<RigidPose>& poses, PointsRef reference) {
    const Vec3 centre = reference.colwise().mean();
    const double radius = std::sqrt((reference.rowwise() - centre.transpose()).rowwise().squaredNorm().mean());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const RigidPose& pose : poses) mean += pose.apply(centre).cast<double>();
    mean /= double(poses.size());
    double sum = 0;
    for (const RigidPose& pose : poses) {
        sum += (pose.apply(centre).cast<double>() - mean).squaredNorm();
        const double turn = pose.rotation.angularDistance(poses.front().rotation) * radius;
        sum += turn * turn;
    }
    const double off = (mean - centre.cast<double>()).norm();
    const double turned = poses.front().rotation.angularDistance(Eigen::Quaternionf::Identity()) * radius;
    return std::sqrt(sum / double(poses.size())) + off + turned;
}

// Steps, means and coded numbers of pose and gaze: the same whatever happens to the components.
void settle_sides(MotionTask& task, const std::vector<RigidPose>& poses, const std::vector<Gaze>& gazes) {
    const int sides = task.shape.side_channels();
    task.side_targets.resize(sides, task.plan.frames);
    task.side_numbers = {};
    if (sides == 0) return;
    for (std::int64_t f = 0; f < task.plan.frames; ++f) {
        int row = 0;
        if (task.shape.pose)
            for (double v : coding::pose_steps(task.sides, poses[std::size_t(f)])) task.side_targets(row++, f) = v;
        if (task.shape.gaze)
            for (double v : coding::gaze_steps(task.sides, gazes[std::size_t(f)])) task.side_targets(row++, f) = v;
    }
    // A rotation vector may come back by the other way round; the turn in between is the short one.
    for (int c = 0; c < sides; ++c) {
        const double mean = task.side_targets.row(c).mean();
        task.sides.side_mean[std::size_t(c)] = std::int32_t(std::clamp(std::round(mean), -double(1 << 28), double(1 << 28)));
        task.side_targets.row(c).array() -= task.sides.side_mean[std::size_t(c)];
    }
    MotionBasis basis = task.sides;
    basis.scheme = task.scheme;
    basis.mean.assign(std::size_t(task.shape.dimension()), 0);
    basis.block = 64;
    basis.static_codes.assign(std::size_t(sides), {});
    if (task.scheme == MotionScheme::causal) train_predictors(basis, task.plan, task.side_targets);
    const GroupOptions options{.lambda = task.scheme == MotionScheme::guenter98 ? 0 : 0.1};
    task.side_numbers = code_groups(basis, task.shape, task.plan, task.side_targets, task.presence, options).numbers;
    if (task.scheme == MotionScheme::causal) task.sides.predictors = basis.predictors;
}

// The poses a decoder will have.
std::vector<RigidPose> decoded_poses(const MotionTask& task) {
    const int sides = task.shape.side_channels();
    MotionBasis basis = task.sides;
    basis.scheme = task.scheme;
    basis.mean.assign(std::size_t(task.shape.dimension()), 0);
    basis.block = 64;
    basis.static_codes.assign(std::size_t(sides), {});
    const GroupOptions options{.choose_splits = false, .settled = &task.side_numbers, .settled_channels = sides};
    const CodedGroups coded = code_groups(basis, task.shape, task.plan, task.side_targets, task.presence, options);
    std::vector<RigidPose> poses;
    for (std::int64_t f = 0; f < task.plan.frames; ++f) {
        std::array<std::int64_t, 6> steps{};
        for (int i = 0; i < 6; ++i) steps[std::size_t(i)] = std::llround(coded.samples(i, f) * MotionBasis::kFraction);
        poses.push_back(coding::pose_of(task.sides, steps));
    }
    return poses;
}

// The head pose of every frame where the clip has one or the motion shows one; else none.
std::vector<RigidPose> head_poses(const Clip& clip, MotionKind kind, PointsRef reference, std::int64_t frames, double guess) {
    if (std::int64_t(clip.head_pose.size()) == frames) return clip.head_pose;
    if (kind == MotionKind::weights) return {};
    if (kind == MotionKind::markers && clip.vertices && clip.neutral && !clip.rigid.empty() && clip.vertices->frames == frames &&
        clip.vertices->points == clip.neutral->positions.rows())
        return steady_poses(*clip.vertices, clip.neutral->positions, clip.rigid);
    const PointSequence& sequence = kind == MotionKind::vertices ? *clip.vertices : *clip.markers;
    if (steadiest_stray(sequence, reference) <= 0.5 * guess) return {};
    const bool rigid_known = kind == MotionKind::vertices || !clip.vertices;
    return steady_poses(sequence, reference, rigid_known ? std::span<const std::uint32_t>(clip.rigid) : std::span<const std::uint32_t>());
}

// Completes a task whose shape, scheme and plan are set: pose and gaze as they are coded, and what is left for components.
// poses: one per frame, or none for a head that stands still.
void settle(MotionTask& task, const Clip& clip, const MotionGoal& goal, PointsRef reference, PointsRef around,
            std::vector<RigidPose> poses, int rungs) {
    task.shape.pose = !poses.empty();
    const double pose_guess = goal.kind == MotionKind::weights ? 0.1 : goal.guess();
    const Vec3 centre = around.colwise().mean();
    const double radius = std::max(1.0, std::sqrt(double((around.rowwise() - centre.transpose()).rowwise().squaredNorm().mean())));
    for (int i = 0; i < 3; ++i) task.sides.centre[std::size_t(i)] = centre[i];
    task.sides.translation_step = float(0.6 * pose_guess);
    task.sides.rotation_step = float(0.6 * pose_guess / radius);
    task.sides.gaze_step = 0.005f;

    MotionMatrix matrix;
    if (task.shape.presence) matrix = motion_matrix(clip, goal.kind, reference, poses);
    task.presence = std::move(matrix.presence);
    settle_sides(task, poses, clip.gaze);
    if (task.shape.pose) poses = decoded_poses(task);

    matrix = motion_matrix(clip, goal.kind, reference, goal.kind == MotionKind::weights ? std::vector<RigidPose>() : poses);
    impute(matrix);
    const double allowed = goal.guess() * goal.guess() * double(std::max<std::int64_t>(1, matrix.present));
    task.components = find_components(matrix.values, 0.01 * allowed, kMostComponents);
    task.poses = std::move(poses);
    if (goal.peak || rungs > 1) task.motion = std::move(matrix);
}

// What a trial says of the motion vectors, d x F.
Eigen::MatrixXf values_of(const MotionTask& task, const MotionTrial& trial) {
    const Eigen::MatrixXf columns = coding::components_of(trial.basis);
    const Eigen::MatrixXf w = (trial.coded.samples.bottomRows(columns.cols()) * MotionBasis::kFraction).cast<float>();
    Eigen::MatrixXf values = columns * w;
    values.colwise() += coding::mean_of(trial.basis);
    const auto corrections = held_corrections(trial.basis, task.plan, task.shape.coordinates, trial.changes);
    for (std::size_t f = 0; f < corrections.size(); ++f)
        for (const model::Correction& correction : corrections[f]) values(Eigen::Index(correction.at), Eigen::Index(f)) += correction.offset;
    return values;
}

// What the rungs up to `answer` have left of `below`: a task of its own, in the components it has already and new ones across them.
// Refers to `answer`.
MotionTask refinement_of(const MotionTask& below, const MotionAnswer& answer, double allowed) {
    const MotionTrial& trial = answer.trial;
    MotionTask task;
    task.shape = {.points = below.shape.points, .coordinates = below.shape.coordinates};
    task.scheme = below.scheme;
    task.plan = below.plan;
    task.triangles = below.triangles;
    task.mirror = below.mirror;
    task.poses = below.poses;
    task.side_targets.resize(0, task.plan.frames);
    task.below = &trial.basis;
    task.below_numbers = &trial.coded.numbers;
    task.below_sides = below.shape.side_channels();
    task.below_values = values_of(below, trial);
    task.motion.presence = below.motion.presence;
    task.motion.present = below.motion.present;
    task.motion.values = below.motion.values - task.below_values;
    if (below.below) task.below_values += below.below_values;

    const Eigen::Index shared = Eigen::Index(trial.basis.size());
    const Eigen::VectorXf mean = task.motion.values.rowwise().mean();
    Eigen::MatrixXf rest = task.motion.values.colwise() - mean;
    Eigen::MatrixXf frame(rest.rows(), shared);
    Eigen::MatrixXd along(shared, rest.cols());
    if (shared > 0) {
        const Eigen::HouseholderQR<Eigen::MatrixXf> qr(coding::components_of(trial.basis));
        frame = qr.householderQ() * Eigen::MatrixXf::Identity(rest.rows(), shared);
        const Eigen::MatrixXf product = frame.transpose() * rest;
        rest.noalias() -= frame * product;
        along = product.cast<double>();
    }
    const MotionComponents own = find_components(rest, 0.01 * allowed, kMostComponents);
    MotionComponents& all = task.components;
    all.mean = mean + own.mean;
    all.left_out = own.left_out;
    all.vectors.resize(rest.rows(), shared + own.vectors.cols());
    all.vectors << frame, own.vectors;
    all.coefficients.resize(shared + own.coefficients.rows(), rest.cols());
    all.coefficients << along, own.coefficients;
    return task;
}

void account(EncodedMotion::Bits& bits, const MotionTrial& trial, int sides) {
    const CodedGroups& coded = trial.coded;
    bits.probabilities += 8.0 * double(trial.stored.probabilities);
    bits.basis += 8.0 * double(trial.stored.bytes.size() - trial.stored.probabilities);
    const double side_bits = coded.bits.head(sides).sum() + coded.presence_bits;
    const double all_bits = coded.bits.sum() + coded.presence_bits + coded.correction_bits;
    const double object_bits = 8.0 * double(coded.bytes);
    const double pose = all_bits > 0 ? side_bits / all_bits * object_bits : 0;
    bits.pose += pose;
    bits.coefficients += object_bits - pose;
}

}  // namespace

Result<EncodedMotion> encode_motion(const Clip& clip, const MotionOptions& options, const Progress& progress) {
    if (options.training) return encode_trained(clip, *options.training, options, progress);
    const auto report = [&](const char* what) {
        if (progress) progress(what, 0, 0);
    };
    MIEN_TRY(goal, goal_of(options));
    if (options.rungs < 1 || options.rungs > MotionOptions::kMaxRungs) return Error{ErrorCode::invalid, "a motion track has 1 to 8 rungs"};
    if (options.rungs > 1 && (options.kbps || options.preset == MotionPreset::guenter98))
        return Error{ErrorCode::invalid, "rungs are made for an error that is asked for, and not of the scheme of 1998"};
    MIEN_CHECK(check_motion(clip, options.kind));
    if (options.group_frames < 0) return Error{ErrorCode::invalid, "a group of less than no frames"};
    const MotionKind kind = options.kind;

    MotionTask task;
    task.scheme = options.preset == MotionPreset::file   ? MotionScheme::transform
                  : options.preset == MotionPreset::live ? MotionScheme::causal
                                                         : MotionScheme::guenter98;
    task.plan = {.frames = clip.frame_count(), .group_frames = options.group_frames};
    const std::int64_t count = kind == MotionKind::vertices  ? clip.vertices->points
                               : kind == MotionKind::markers ? clip.markers->points
                                                             : clip.weights->count;
    const std::int64_t own_frames = kind == MotionKind::vertices  ? clip.vertices->frames
                                    : kind == MotionKind::markers ? clip.markers->frames
                                                                  : clip.weights->frames;
    task.plan.frames = own_frames;
    const std::int64_t limit = kind == MotionKind::vertices  ? protocol::kMaxVertices
                               : kind == MotionKind::markers ? protocol::kMaxMarkers
                                                             : protocol::kMaxWeights;
    if (count > limit) return Error{ErrorCode::limit_exceeded, std::to_string(count) + " points are more than a stream holds"};
    if (task.plan.frames > coding::MotionFrames::kMaxFrames && options.group_frames == 0 && task.scheme != MotionScheme::causal)
        return Error{ErrorCode::limit_exceeded, "a clip this long needs groups"};
    task.shape.points = std::uint32_t(count);
    task.shape.coordinates = kind == MotionKind::weights ? 1 : 3;

    Points reference;
    if (kind != MotionKind::weights) {
        reference = options.reference ? *options.reference : reference_points(clip, kind);
        if (reference.rows() != count)
            return Error{ErrorCode::mismatch, "the neutral has " + std::to_string(reference.rows()) + " points, the motion " +
                                                  std::to_string(count)};
    }

    task.shape.gaze = kind != MotionKind::vertices && std::int64_t(clip.gaze.size()) == task.plan.frames;
    task.shape.presence = kind == MotionKind::markers && has_missing_markers(clip);
    if (kind == MotionKind::vertices && clip.neutral) task.triangles = clip.neutral->triangles, task.mirror = options.mirror;

    report("head pose");
    Points around = reference;
    if (kind == MotionKind::weights && clip.neutral) around = clip.neutral->positions;
    if (around.rows() == 0) around = 100 * Points::Identity(3, 3);
    const double pose_guess = kind == MotionKind::weights ? 0.1 : goal.guess();
    std::vector<RigidPose> poses = head_poses(clip, kind, reference, task.plan.frames, goal.guess());
    const double spread = poses.empty() ? 0 : pose_spread(poses, around);
    if (spread < 0.5 * pose_guess) poses.clear();
    // Of a head that hardly moves, the "pose" is mostly what its skin does: only the bits tell whether it is worth sending.
    const bool nearly_still = !poses.empty() && clip.head_pose.empty() && spread < kNearlyStill * pose_guess;

    report("motion basis");
    std::optional<MotionTask> still;
    if (nearly_still) settle(still.emplace(task), clip, goal, reference, around, {}, options.rungs);
    settle(task, clip, goal, reference, around, std::move(poses), options.rungs);
    const MotionGoal first = options.rungs == 1 ? goal : MotionGoal{.rms = goal.guess() * double(1 << (options.rungs - 1)), .kind = kind};
    MIEN_TRY(best, meet(first, clip, task, reference, progress));
    if (still) {
        auto answer = meet(first, clip, *still, reference, progress);
        if (answer.ok() && better(first, *answer, best)) {
            best = std::move(*answer);
            task = std::move(*still);
        }
    }

    EncodedMotion out;
    out.info = {.kind = kind, .count = task.shape.points, .has_pose = task.shape.pose, .has_gaze = task.shape.gaze,
                .has_presence = task.shape.presence};
    out.rms = best.errors.rms;
    out.peak = best.errors.peak;
    account(out.bits, best.trial, task.shape.side_channels());

    const double allowed = goal.guess() * goal.guess() * double(std::max<std::int64_t>(1, task.motion.present));
    std::vector<std::unique_ptr<MotionTask>> tasks;
    std::vector<std::unique_ptr<MotionAnswer>> answers;   // both stay where they are: what follows refers to them
    for (int r = 1; r < options.rungs; ++r) {
        const MotionTask& below = tasks.empty() ? task : *tasks.back();
        tasks.push_back(std::make_unique<MotionTask>(refinement_of(below, answers.empty() ? best : *answers.back(), allowed)));
        const bool highest = r + 1 == options.rungs;
        const MotionGoal next = highest ? goal : MotionGoal{.rms = goal.guess() * double(1 << (options.rungs - 1 - r)), .kind = kind};
        MIEN_TRY(answer, meet(next, clip, *tasks.back(), reference, progress));
        answers.push_back(std::make_unique<MotionAnswer>(std::move(answer)));
        const MotionTrial& trial = answers.back()->trial;
        account(out.bits, trial, 0);
        out.refinements.push_back({trial.stored.bytes, trial.coded.groups, trial.coded.state_hashes, answers.back()->errors.rms, answers.back()->errors.peak});
        out.rms = answers.back()->errors.rms;
        out.peak = answers.back()->errors.peak;
    }
    out.basis = std::move(best.trial.stored.bytes);
    out.groups = std::move(best.trial.coded.groups);
    out.state_hashes = std::move(best.trial.coded.state_hashes);
    return out;
}

}  // namespace mien::encoder
