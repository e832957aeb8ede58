#include "encoder/motion_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "coding/motion_values.hpp"
#include "core/parallel.hpp"
#include "encoder/motion_matrix.hpp"
#include "encoder/motion_pose.hpp"
#include "encoder/motion_search.hpp"
#include "encoder/reference_points.hpp"
#include "protocol/limits.hpp"

namespace mien::encoder {
namespace {

using coding::MotionBasis;
using coding::MotionScheme;
using protocol::MotionKind;

struct Asked {
    enum class What { rms, peak, kbps } what = What::rms;
    double value = 0.1;
};

Result<Asked> asked_of(const MotionOptions& options) {
    const int set = int(options.rms.has_value()) + int(options.peak.has_value()) + int(options.kbps.has_value());
    if (set != 1) return Error{ErrorCode::invalid, "exactly one of RMS error, peak error and bitrate can be asked for"};
    const double value = options.rms ? *options.rms : options.peak ? *options.peak : *options.kbps;
    if (!(value > 0) || !std::isfinite(value)) return Error{ErrorCode::invalid, "the asked error or bitrate is not a positive number"};
    return Asked{options.rms ? Asked::What::rms : options.peak ? Asked::What::peak : Asked::What::kbps, value};
}

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

struct Measured {
    double rms = 0, peak = 0;
};

// Errors of a trial in the clip's own space, from the values a decoder has.
Measured measure(const Clip& clip, MotionKind kind, const MotionTask& task, const MotionTrial& trial, PointsRef reference) {
    const Eigen::VectorXf mean = coding::mean_of(trial.basis);
    const Eigen::MatrixXf columns = coding::components_of(trial.basis);
    std::vector<double> squared(std::size_t(task.plan.frames), 0), peaks(squared), counts(squared);
    parallel_for(task.plan.frames, [&](std::int64_t f) {
        const Eigen::VectorXf w = (trial.coded.samples.col(f).tail(columns.cols()) * MotionBasis::kFraction).cast<float>();
        Eigen::VectorXf x = mean + columns * w;
        double& sum = squared[std::size_t(f)];
        double& peak = peaks[std::size_t(f)];
        if (kind == MotionKind::weights) {
            const Eigen::Map<const Eigen::VectorXf> truth(clip.weights->frame(f), clip.weights->count);
            sum = (x - truth).cast<double>().squaredNorm();
            peak = double((x - truth).cwiseAbs().maxCoeff());
            counts[std::size_t(f)] = double(truth.size());
            return;
        }
        PointsMap points(x.data(), reference.rows(), 3);
        points += reference;
        if (task.shape.pose) {
            std::array<std::int64_t, 6> steps{};
            for (int i = 0; i < 6; ++i)
                steps[std::size_t(i)] = std::llround(trial.coded.samples(i, f) * MotionBasis::kFraction);
            apply_pose(coding::pose_of(trial.basis, steps), points);
        }
        const auto truth = kind == MotionKind::vertices ? clip.vertices->frame(f) : clip.markers->frame(f);
        for (Eigen::Index p = 0; p < points.rows(); ++p) {
            if (std::isnan(truth(p, 0))) continue;
            const double error = (points.row(p) - truth.row(p)).cast<double>().squaredNorm();
            sum += error;
            peak = std::max(peak, std::sqrt(error));
            counts[std::size_t(f)] += 1;
        }
    });
    Measured out;
    double sum = 0, count = 0;
    for (std::size_t f = 0; f < squared.size(); ++f) {
        sum += squared[f];
        count += counts[f];
        out.peak = std::max(out.peak, peaks[f]);
    }
    out.rms = count > 0 ? std::sqrt(sum / count) : 0;
    return out;
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

const char* unit_of(MotionKind kind) { return kind == MotionKind::weights ? "" : " mm"; }

}  // namespace

Result<EncodedMotion> encode_motion(const Clip& clip, const MotionOptions& options, const Progress& progress) {
    const auto report = [&](const char* what, std::int64_t done, std::int64_t total) {
        if (progress) progress(what, done, total);
    };
    MIEN_TRY(asked, asked_of(options));
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

    // Head pose.
    report("head pose", 0, 0);
    const double guess = asked.what == Asked::What::rms    ? asked.value
                         : asked.what == Asked::What::peak ? asked.value / 5
                                                           : (kind == MotionKind::weights ? 0.005 : 0.1);
    std::vector<RigidPose> poses;
    if (std::int64_t(clip.head_pose.size()) == task.plan.frames) {
        poses = clip.head_pose;
    } else if (kind != MotionKind::weights) {
        if (kind == MotionKind::markers && clip.vertices && clip.neutral && !clip.rigid.empty() &&
            clip.vertices->frames == own_frames && clip.vertices->points == clip.neutral->positions.rows())
            poses = steady_poses(*clip.vertices, clip.neutral->positions, clip.rigid);
        else if (steadiest_stray(kind == MotionKind::vertices ? *clip.vertices : *clip.markers, reference) > 0.5 * guess)
            poses = steady_poses(kind == MotionKind::vertices ? *clip.vertices : *clip.markers, reference,
                                 kind == MotionKind::vertices || !clip.vertices ? std::span<const std::uint32_t>(clip.rigid)
                                                                                : std::span<const std::uint32_t>());
    }
    Points around = reference;
    if (kind == MotionKind::weights && clip.neutral) around = clip.neutral->positions;
    if (around.rows() == 0) around = 100 * Points::Identity(3, 3);
    const double pose_guess = kind == MotionKind::weights ? 0.1 : guess;
    if (!poses.empty() && pose_spread(poses, around) < 0.5 * pose_guess) poses.clear();
    task.shape.pose = !poses.empty();
    task.shape.gaze = kind != MotionKind::vertices && std::int64_t(clip.gaze.size()) == task.plan.frames;
    task.shape.presence = kind == MotionKind::markers && has_missing_markers(clip);

    const Vec3 centre = around.colwise().mean();
    const double radius = std::max(1.0, std::sqrt(double((around.rowwise() - centre.transpose()).rowwise().squaredNorm().mean())));
    for (int i = 0; i < 3; ++i) task.sides.centre[std::size_t(i)] = centre[i];
    task.sides.translation_step = float(0.6 * pose_guess);
    task.sides.rotation_step = float(0.6 * pose_guess / radius);
    task.sides.gaze_step = 0.005f;

    MotionMatrix matrix;
    if (task.shape.presence) matrix = motion_matrix(clip, kind, reference, poses);
    task.presence = std::move(matrix.presence);
    settle_sides(task, poses, clip.gaze);
    if (task.shape.pose) poses = decoded_poses(task);

    report("motion basis", 0, 0);
    matrix = motion_matrix(clip, kind, reference, kind == MotionKind::weights ? std::vector<RigidPose>() : poses);
    impute(matrix);
    const double allowed = guess * guess * double(std::max<std::int64_t>(1, matrix.present));
    task.components = find_components(matrix.values, 0.01 * allowed, 320);
    matrix.values.resize(0, 0);
    if (kind == MotionKind::vertices && clip.neutral) task.triangles = clip.neutral->triangles, task.mirror = options.mirror;

    // Search for the step that just meets what was asked.
    MotionSearch search(task);
    const double seconds = double(task.plan.frames) / clip.frame_rate.value();
    const auto figure = [&](const MotionTrial& trial, const Measured& measured) {
        switch (asked.what) {
            case Asked::What::rms: return measured.rms;
            case Asked::What::peak: return measured.peak;
            case Asked::What::kbps: return trial.bits() / seconds / 1000;
        }
        return 0.0;
    };
    // Bits fall and errors grow with the step: `wanted` tells which way the figure has to go.
    const double direction = asked.what == Asked::What::kbps ? -1 : 1;
    double step = guess * std::sqrt(12.0 * double(task.shape.points) / double(std::clamp<Eigen::Index>(task.components.vectors.cols(), 4, 24)));
    std::optional<MotionTrial> best;
    Measured best_measured;
    double best_figure = 0, low = 0, high = 0, low_figure = 0, high_figure = 0;
    constexpr int kTrials = 24;
    for (int trial_number = 0; trial_number < kTrials; ++trial_number) {
        report("motion", trial_number, kTrials);
        MotionTrial trial = search.run(step);
        const Measured measured = measure(clip, kind, task, trial, reference);
        const double got = figure(trial, measured);
        const bool meets = got <= asked.value;
        if (meets && (!best || (direction > 0 ? trial.bits() < best->bits() : measured.rms < best_measured.rms))) {
            best = std::move(trial);
            best_measured = measured;
            best_figure = got;
        }
        const bool too_fine = direction > 0 ? meets : !meets;   // a larger step is allowed or needed
        if (too_fine) low = step, low_figure = got;
        else high = step, high_figure = got;
        if (best && best_figure > 0.996 * asked.value) break;
        const double ratio = std::max(1e-6, got) / asked.value;
        if (low > 0 && high > 0) {
            if (high / low < 1.0005) break;
            // Between the two on a log-log line, kept off the ends.
            const double goal = std::log(asked.value * 0.9985);
            double t = 0.5;
            const double a = std::log(std::max(1e-9, low_figure)), b = std::log(std::max(1e-9, high_figure));
            if (std::abs(b - a) > 1e-6 && trial_number % 5 != 4) t = (goal - a) / (b - a);
            step = std::exp(std::log(low) + std::clamp(t, 0.05, 0.95) * (std::log(high) - std::log(low)));
        } else {
            const double move = std::clamp(std::pow(ratio, direction > 0 ? -1.05 : 1.3), 0.1, 10.0);
            step *= too_fine ? std::max(move, 1.02) : std::min(move, 0.98);
        }
        if (step > 1e6 || step < 1e-9) break;
    }
    if (!best) {
        const std::string what = asked.what == Asked::What::rms ? "RMS error" : asked.what == Asked::What::peak ? "peak error" : "bitrate";
        return Error{ErrorCode::invalid, "the asked " + what + " of " + std::to_string(asked.value) +
                                             (asked.what == Asked::What::kbps ? " kbit/s" : unit_of(kind)) +
                                             " cannot be met: this motion needs more"};
    }

    EncodedMotion out;
    out.info = {.kind = kind, .count = task.shape.points, .has_pose = task.shape.pose, .has_gaze = task.shape.gaze,
                .has_presence = task.shape.presence};
    out.rms = best_measured.rms;
    out.peak = best_measured.peak;
    out.bits.probabilities = 8.0 * double(best->stored.probabilities);
    out.bits.basis = 8.0 * double(best->stored.bytes.size()) - out.bits.probabilities;
    const int sides = task.shape.side_channels();
    const double side_bits = best->coded.bits.head(sides).sum() + best->coded.presence_bits;
    const double all_bits = best->coded.bits.sum() + best->coded.presence_bits;
    const double object_bits = 8.0 * double(best->coded.bytes);
    out.bits.pose = all_bits > 0 ? side_bits / all_bits * object_bits : 0;
    out.bits.coefficients = object_bits - out.bits.pose;
    out.basis = std::move(best->stored.bytes);
    out.groups = std::move(best->coded.groups);
    out.state_hashes = std::move(best->coded.state_hashes);
    report("motion", kTrials, kTrials);
    return out;
}

}  // namespace mien::encoder
