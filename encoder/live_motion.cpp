#include "encoder/live_motion.hpp"

#include <cmath>
#include <string>

#include "coding/motion_values.hpp"
#include "encoder/frame_decision.hpp"

namespace mien::encoder {

namespace {

using coding::MotionBasis;
using coding::MotionFrames;
using protocol::MotionKind;

constexpr double kSideSlope = 0.1;    // squared steps per bit: pose first, as it moves everything
constexpr double kSlope = 0.12;
constexpr double kMost = 1 << 20;     // steps: above it predictions could leave the range of what is coded

}  // namespace

struct LiveMotion::State {
    State(const TrainingTake& training, PointsRef reference, std::optional<float> step)
        : take(training), stored(with_step(training, step)), shape(shape_of(training)), frames(stored, shape), projector(take, stored, reference) {}

    static MotionBasis with_step(const TrainingTake& take, std::optional<float> step) {
        MotionBasis basis = basis_for(take, coding::MotionScheme::causal);
        if (step) basis.step = *step;
        return basis;
    }
    static coding::MotionShape shape_of(const TrainingTake& take) {
        coding::MotionShape shape = take.shape();
        shape.presence = take.info.kind == MotionKind::markers;
        return shape;
    }

    const TrainingTake take;
    const MotionBasis stored;
    const coding::MotionShape shape;
    MotionFrames frames;
    FrameProjector projector;
    protocol::MotionInfo info;
    coding::BasisBytes bytes;
    std::vector<std::int64_t> samples;
    std::uint64_t digest = 0;
    Figures figures;
    double squared_error = 0, points = 0;

    std::vector<std::int32_t> settle_sides(const Eigen::VectorXd& targets, Eigen::VectorXd& decoded);
};

// Pose and gaze by themselves first: what is left for the coefficients depends on how they decode.
std::vector<std::int32_t> LiveMotion::State::settle_sides(const Eigen::VectorXd& targets, Eigen::VectorXd& decoded) {
    FrameCosts costs(frames);
    FramePath path = choose_path(costs, int(targets.size()), kSideSlope, [&](int c) { return targets[c]; },
                                 [](int) { return std::optional<std::int32_t>(); });
    decoded = Eigen::Map<const Eigen::VectorXd>(path.decoded.data(), targets.size());
    return path.numbers;
}

LiveMotion::LiveMotion(const TrainingTake& take, PointsRef reference, std::optional<float> step, std::span<const Triangle> triangles,
                       std::span<const std::uint32_t> mirror)
    : state_(std::make_unique<State>(take, reference, step)) {
    State& s = *state_;
    s.info = take.info;
    s.info.has_presence = s.shape.presence;
    s.bytes = coding::write_motion_basis(s.stored, s.shape, coding::basis_order(s.stored, s.shape, triangles, mirror));
    s.frames.begin_group();
}

LiveMotion::~LiveMotion() = default;

const protocol::MotionInfo& LiveMotion::info() const { return state_->info; }
const Bytes& LiveMotion::basis() const { return state_->bytes.bytes; }
std::size_t LiveMotion::probability_bytes() const { return state_->bytes.probabilities; }
const std::vector<std::int64_t>& LiveMotion::samples() const { return state_->samples; }
std::uint64_t LiveMotion::state_hash() const { return state_->digest; }
void LiveMotion::begin_group() { state_->frames.begin_group(); }

LiveMotion::Figures LiveMotion::figures() const {
    Figures figures = state_->figures;
    figures.rms = state_->points > 0 ? std::sqrt(state_->squared_error / state_->points) : 0;
    return figures;
}

Result<protocol::Object> LiveMotion::encode(const MotionFrame& frame) {
    State& s = *state_;
    MIEN_CHECK(check_frame(frame, s.info));
    s.frames.begin_object(1);
    const Eigen::VectorXd side_targets = s.projector.sides(frame);
    Eigen::VectorXd decoded_sides;
    if ((side_targets.array().abs() > kMost).any()) return Error{ErrorCode::invalid, "the head is too far off to be coded"};
    const std::vector<std::int32_t> side_numbers = s.settle_sides(side_targets, decoded_sides);
    const Eigen::VectorXd coefficients = s.projector.coefficients(frame, decoded_sides);
    if ((coefficients.array().abs() > kMost).any()) return Error{ErrorCode::invalid, "the points are too far off to be coded"};
    const int sides = int(side_numbers.size());
    const auto target = [&](int c) { return c < sides ? decoded_sides[c] : coefficients[c - sides]; };
    const auto settled = [&](int c) { return c < sides ? std::optional(side_numbers[std::size_t(c)]) : std::nullopt; };

    Metered coder;
    if (s.shape.presence) {
        std::vector<std::uint8_t> presence(s.shape.points);
        for (std::size_t p = 0; p < presence.size(); ++p) presence[p] = !std::isnan(frame.values[3 * Eigen::Index(p)]);
        s.frames.code_presence(coder, 1, presence);
        s.figures.pose_bits += coder.take_bits();
    }
    const FramePath path = choose_packet(s.frames, coder, kSlope, target, settled);
    s.frames.code_frame(coder, [&](int c) {
        if (c == sides) s.figures.pose_bits += coder.take_bits();
        return path.numbers[std::size_t(c)];
    });
    const double bits = coder.take_bits();
    (s.stored.size() > 0 ? s.figures.coefficient_bits : s.figures.pose_bits) += bits;
    s.frames.store_frame(0, 1);
    s.digest = coder.digest();

    const int channels = s.frames.layout().total();
    s.samples.resize(std::size_t(channels));
    Eigen::VectorXd decoded(channels);
    for (int c = 0; c < channels; ++c) {
        s.samples[std::size_t(c)] = s.frames.sample(c, 0, 1);
        decoded[c] = double(s.samples[std::size_t(c)]) / MotionBasis::kFraction;
    }
    const FrameProjector::Errors errors = s.projector.errors(frame, decoded);
    s.squared_error += errors.squared;
    s.points += double(errors.points);
    s.figures.peak = std::max(s.figures.peak, errors.peak);
    ++s.figures.frames;
    protocol::Object object{.frames = 1, .bytes = coder.finish()};
    s.figures.bytes += object.bytes.size();
    return object;
}

Result<void> check_frame(const MotionFrame& frame, const protocol::MotionInfo& info) {
    const bool weights = info.kind == MotionKind::weights;
    const Eigen::Index wanted = Eigen::Index(info.count) * (weights ? 1 : 3);
    if (frame.values.size() != wanted)
        return Error{ErrorCode::mismatch, "a frame of " + std::to_string(frame.values.size()) + " numbers; the basis has " + std::to_string(info.count) +
                                              (weights ? " weights" : " points of 3")};
    if (weights) {
        for (Eigen::Index i = 0; i < wanted; ++i)
            if (!(std::abs(frame.values[i]) < 1e4f)) return Error{ErrorCode::invalid, "weight " + std::to_string(i) + " is not a usable number"};
        return {};
    }
    for (Eigen::Index p = 0; p < Eigen::Index(info.count); ++p) {
        const auto at = frame.values.segment<3>(3 * p);
        if (at.allFinite() && at.cwiseAbs().maxCoeff() < 1e5f) continue;
        if (info.kind == MotionKind::markers && at.array().isNaN().all()) continue;
        return Error{ErrorCode::invalid, "point " + std::to_string(p) + " is not a usable position"};
    }
    return {};
}

}  // namespace mien::encoder
