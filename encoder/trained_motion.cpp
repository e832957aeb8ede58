#include "encoder/trained_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "encoder/live_motion.hpp"
#include "encoder/motion_goal.hpp"
#include "encoder/motion_groups.hpp"
#include "encoder/motion_matrix.hpp"

namespace mien::encoder {

namespace {

using coding::MotionBasis;
using protocol::MotionKind;

constexpr int kTrials = 16;
constexpr double kNearEnough = 0.992;   // of the asked error

std::vector<MotionFrame> frames_of(const Clip& clip, MotionKind kind) {
    std::vector<MotionFrame> frames(std::size_t(clip.frame_count()));
    for (std::size_t f = 0; f < frames.size(); ++f) {
        MotionFrame& frame = frames[f];
        const auto at = std::int64_t(f);
        if (kind == MotionKind::weights) frame.values = Eigen::Map<const Eigen::VectorXf>(clip.weights->frame(at), clip.weights->count);
        else frame.values = Eigen::Map<const Eigen::VectorXf>(clip.markers->frame(at).data(), 3 * clip.markers->points);
        if (clip.head_pose.size() == frames.size()) frame.pose = clip.head_pose[f];
        if (clip.gaze.size() == frames.size()) frame.gaze = clip.gaze[f];
    }
    return frames;
}

struct Sum {
    double squared = 0, peak = 0, points = 0;
    void add(const FrameProjector::Errors& e) {
        squared += e.squared;
        peak = std::max(peak, e.peak);
        points += double(e.points);
    }
    double rms() const { return points > 0 ? std::sqrt(squared / points) : 0; }
};

struct Trial {
    EncodedMotion motion;
    double figure = 0;   ///< over what was asked: at most 1 meets it
};

class Trials {
public:
    Trials(const Clip& clip, const TrainingTake& take, const MotionOptions& options)
        : take_(take), options_(options), frames_(frames_of(clip, options.kind)), presence_(options.kind == MotionKind::markers && has_missing_markers(clip)),
          plan_{.frames = std::int64_t(frames_.size()), .group_frames = options.group_frames},
          reference_(options.reference ? *options.reference : Points(0, 3)) {}

    Result<Trial> run(float step) const { return options_.preset == MotionPreset::live ? live(step) : Result<Trial>(transform(step)); }

    /// The larger of both errors over the one that was asked for.
    double over_asked(double rms, double peak) const {
        return std::max(options_.rms ? rms / *options_.rms : 0, options_.peak ? peak / *options_.peak : 0);
    }

    /// What the basis leaves of the clip when nothing is rounded.
    Sum floor() const {
        const MotionBasis basis = basis_for(take_, coding::MotionScheme::causal);
        FrameProjector projector(take_, basis, reference_);
        Sum sum;
        for (const MotionFrame& frame : frames_) {
            const Eigen::VectorXd sides = projector.sides(frame);
            Eigen::VectorXd all(basis.channels(take_.shape()));
            all << sides, projector.coefficients(frame, sides);
            sum.add(projector.errors(frame, all));
        }
        return sum;
    }

private:
    Trial finish(EncodedMotion motion) const {
        const double figure = over_asked(motion.rms, motion.peak);
        return {std::move(motion), figure};
    }

    Result<Trial> live(float step) const {
        LiveMotion coder(take_, reference_, step);
        EncodedMotion out;
        out.info = coder.info();
        out.basis = coder.basis();
        out.bits.probabilities = 8.0 * double(coder.probability_bytes());
        for (std::int64_t g = 0; g < plan_.count(); ++g) {
            coder.begin_group();
            protocol::Group group{.slot = 0, .group = std::uint32_t(g), .first_time = plan_.first(g), .objects = {}};
            for (std::int64_t f = plan_.first(g); f < plan_.first(g) + plan_.length(g); ++f) {
                MIEN_TRY(object, coder.encode(frames_[std::size_t(f)]));
                group.objects.push_back(std::move(object));
                out.state_hashes.push_back(coder.state_hash());
            }
            out.groups.push_back(std::move(group));
        }
        const LiveMotion::Figures figures = coder.figures();
        out.rms = figures.rms;
        out.peak = figures.peak;
        split(out, figures.pose_bits, figures.pose_bits + figures.coefficient_bits, figures.bytes);
        return finish(std::move(out));
    }

    Trial transform(float step) const {
        MotionBasis basis = basis_for(take_, coding::MotionScheme::transform);
        basis.step = step;
        coding::MotionShape shape = take_.shape();
        shape.presence = presence_;
        FrameProjector projector(take_, basis, reference_);
        const int sides = shape.side_channels();
        std::vector<std::uint8_t> present;
        Eigen::MatrixXd targets = Eigen::MatrixXd::Zero(basis.channels(shape), plan_.frames);
        for (std::int64_t f = 0; f < plan_.frames; ++f) {
            const MotionFrame& frame = frames_[std::size_t(f)];
            targets.col(f).head(sides) = projector.sides(frame);
            if (presence_)
                for (std::uint32_t p = 0; p < shape.points; ++p) present.push_back(!std::isnan(frame.values[3 * Eigen::Index(p)]));
        }
        // Pose and gaze are settled first, as in encode_motion: what is left for the coefficients depends on how they decode.
        const GroupOptions alone{.lambda = 0.1};
        const CodedGroups settled = code_groups(basis, shape, plan_, targets, present, alone);
        for (std::int64_t f = 0; f < plan_.frames; ++f)
            targets.col(f).tail(basis.size()) = projector.coefficients(frames_[std::size_t(f)], settled.samples.col(f).head(sides));
        const GroupOptions options{.settled = &settled.numbers, .settled_channels = sides};
        CodedGroups coded = code_groups(basis, shape, plan_, targets, present, options);

        EncodedMotion out;
        out.info = take_.info;
        out.info.has_presence = presence_;
        Sum sum;
        for (std::int64_t f = 0; f < plan_.frames; ++f) sum.add(projector.errors(frames_[std::size_t(f)], coded.samples.col(f)));
        out.rms = sum.rms();
        out.peak = sum.peak;
        const coding::BasisBytes stored = write_motion_basis(basis, shape, coding::basis_order(basis, shape, {}, {}));
        out.basis = stored.bytes;
        out.bits.probabilities = 8.0 * double(stored.probabilities);
        split(out, coded.bits.head(sides).sum() + coded.presence_bits, coded.bits.sum() + coded.presence_bits, coded.bytes);
        out.groups = std::move(coded.groups);
        out.state_hashes = std::move(coded.state_hashes);
        return finish(std::move(out));
    }

    static void split(EncodedMotion& out, double side_bits, double all_bits, std::uint64_t bytes) {
        out.bits.basis = 8.0 * double(out.basis.size()) - out.bits.probabilities;
        out.bits.pose = all_bits > 0 ? side_bits / all_bits * 8 * double(bytes) : 0;
        out.bits.coefficients = 8 * double(bytes) - out.bits.pose;
    }

    const TrainingTake& take_;
    const MotionOptions& options_;
    const std::vector<MotionFrame> frames_;
    const bool presence_;
    const GroupPlan plan_;
    const Points reference_;
};

}  // namespace

Result<EncodedMotion> encode_trained(const Clip& clip, const TrainingTake& take, const MotionOptions& options, const Progress& progress) {
    if (const auto goal = goal_of(options); !goal) return goal.error();
    MIEN_CHECK(check_motion(clip, options.kind));
    if (options.preset == MotionPreset::guenter98 || options.kbps)
        return Error{ErrorCode::invalid, "a basis of a training take goes with the presets file and live, and with an error to meet"};
    if (options.rungs != 1) return Error{ErrorCode::invalid, "a basis of a training take makes one rung"};
    if (options.kind == MotionKind::vertices || options.kind != take.info.kind)
        return Error{ErrorCode::mismatch, "a basis of a training take goes with the markers or weights that it is made of"};
    const std::int64_t count = options.kind == MotionKind::markers ? clip.markers->points : clip.weights->count;
    if (count != take.info.count)
        return Error{ErrorCode::mismatch, fmt::format("the training take has {} {}, the clip {}", take.info.count,
                                                      options.kind == MotionKind::markers ? "markers" : "weights", count)};
    if (options.kind == MotionKind::markers && (!options.reference || options.reference->rows() != count))
        return Error{ErrorCode::mismatch, "the training take's model has no such markers"};

    const char* unit = options.kind == MotionKind::weights ? "" : " mm";
    const Trials trials(clip, take, options);
    const Sum floor = trials.floor();
    std::string asked = options.rms ? fmt::format("{:.4f}{} RMS", *options.rms, unit) : "";
    if (options.peak) asked += fmt::format("{}{:.4f}{} at most", asked.empty() ? "" : ", ", *options.peak, unit);
    const std::string left = fmt::format("the training take's basis leaves {:.4f}{} RMS and {:.4f}{} at most of this clip", floor.rms(), unit, floor.peak, unit);
    if (trials.over_asked(floor.rms(), floor.peak) > 1)
        return Error{ErrorCode::invalid, fmt::format("{}, and {} was asked for: it lacks motions that the clip has, or was encoded too coarsely", left, asked)};
    // Errors grow with the step: the largest that meets the goal.
    double step = take.basis.step, low = 0, high = 0;
    std::optional<Trial> best;
    for (int t = 0; t < kTrials; ++t) {
        if (progress) progress("motion", t, kTrials);
        MIEN_TRY(trial, trials.run(float(step)));
        const double figure = trial.figure;
        const bool meets = figure <= 1;
        (meets ? low : high) = step;
        if (meets && (!best || figure > best->figure)) best = std::move(trial);
        if (best && best->figure > kNearEnough) break;
        if (low > 0 && high > 0) {
            if (high / low < 1.001) break;
            step = std::sqrt(low * high);
        } else {
            const double move = std::clamp(1 / std::max(figure, 1e-9), 0.25, 4.0);
            step *= meets ? std::max(move, 1.05) : std::min(move, 0.95);
        }
    }
    if (!best) return Error{ErrorCode::invalid, fmt::format("{} cannot be met: {}", asked, left)};
    if (progress) progress("motion", kTrials, kTrials);
    return std::move(best->motion);
}

}  // namespace mien::encoder
