#include "decoder/motion_decoder.hpp"

#include "coding/motion_basis.hpp"
#include "coding/motion_frames.hpp"
#include "coding/motion_values.hpp"
#include "protocol/limits.hpp"

namespace mien::decoder {
namespace {

coding::MotionShape shape_of(const protocol::MotionInfo& info) {
    return {.points = info.count,
            .coordinates = info.kind == protocol::MotionKind::weights ? 1u : 3u,
            .pose = info.has_pose,
            .gaze = info.has_gaze,
            .presence = info.has_presence};
}

std::uint32_t most_points(protocol::MotionKind kind) {
    switch (kind) {
        case protocol::MotionKind::vertices: return protocol::kMaxVertices;
        case protocol::MotionKind::markers: return protocol::kMaxMarkers;
        case protocol::MotionKind::weights: return protocol::kMaxWeights;
    }
    return 0;
}

}  // namespace

struct MotionDecoder::State {
    State(coding::MotionBasis stored_, const coding::MotionShape& shape_)
        : stored(std::move(stored_)), shape(shape_), frames(stored, shape) {
        basis.mean = coding::mean_of(stored);
        basis.components = coding::components_of(stored);
        // Only lengths and steps matter from here on.
        for (auto& component : stored.components) component = {};
    }
    coding::MotionBasis stored;
    coding::MotionShape shape;
    coding::MotionFrames frames;
    model::LinearMotion basis;
    bool broken = false;
    std::uint64_t digest = 0;
    Split split;
};

Result<MotionDecoder> MotionDecoder::create(const protocol::MotionInfo& info, ByteView basis,
                                            std::span<const Triangle> triangles, std::span<const std::uint32_t> mirror) {
    if (info.count == 0 || info.count > most_points(info.kind))
        return Error{ErrorCode::limit_exceeded, "a motion track of " + std::to_string(info.count) + " points"};
    const coding::MotionShape shape = shape_of(info);
    MIEN_TRY(stored, coding::read_motion_basis(shape, basis, triangles, mirror));
    return MotionDecoder(std::make_unique<State>(std::move(stored), shape));
}

MotionDecoder::MotionDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
MotionDecoder::MotionDecoder(MotionDecoder&&) noexcept = default;
MotionDecoder& MotionDecoder::operator=(MotionDecoder&&) noexcept = default;
MotionDecoder::~MotionDecoder() = default;

const model::LinearMotion& MotionDecoder::basis() const { return state_->basis; }
std::uint64_t MotionDecoder::state_hash() const { return state_->digest; }
MotionDecoder::Split MotionDecoder::split() const { return state_->split; }

void MotionDecoder::begin_group() {
    state_->broken = false;
    state_->frames.begin_group();
}

Result<std::vector<model::Motion>> MotionDecoder::decode(const protocol::Object& object, std::int64_t first_frame) {
    State& s = *state_;
    const auto refuse = [&](ErrorCode code, std::string why) {
        s.broken = true;
        return Error{code, std::move(why)};
    };
    if (s.broken) return Error{ErrorCode::damaged, "motion: an earlier object of this group was damaged"};
    const std::uint32_t n = object.frames;
    const coding::MotionChannels& layout = s.frames.layout();
    if (n == 0 || n > coding::MotionFrames::kMaxFrames ||
        std::uint64_t(n) * std::uint64_t(layout.total() + 1) > coding::MotionFrames::kMaxSamples ||
        (s.shape.presence && std::uint64_t(n) * s.shape.points > coding::MotionFrames::kMaxSamples) ||
        object.bytes.size() > protocol::kMaxObjectBytes)
        return refuse(ErrorCode::limit_exceeded, "a motion object of " + std::to_string(n) + " frames");

    coding::MeteredDecoder coder(object.bytes);
    std::vector<std::uint8_t> presence;
    coder.enter(true);
    if (s.shape.presence) s.frames.code_presence(coder, n, presence);
    s.frames.decode(coder, n);
    if (!coder.complete())
        return refuse(ErrorCode::damaged, "motion: the object of frame " + std::to_string(first_frame) +
                                              " does not end where it should");
    s.digest = coder.digest();
    const double ideal = coder.bits(true) + coder.bits(false);
    if (ideal > 0) {
        const double scale = double(object.bytes.size()) * 8 / ideal;
        s.split.pose += coder.bits(true) * scale;
        s.split.coefficients += coder.bits(false) * scale;
    }

    std::vector<model::Motion> out(n);
    for (std::uint32_t f = 0; f < n; ++f) {
        model::Motion& motion = out[f];
        motion.frame = first_frame + f;
        int channel = 0;
        const auto next = [&] { return s.frames.sample(channel++, f, n); };
        if (s.shape.pose) {
            std::array<std::int64_t, 6> steps{};
            for (auto& step : steps) step = next();
            motion.pose = coding::pose_of(s.stored, steps);
        }
        if (s.shape.gaze) {
            std::array<std::int64_t, 4> steps{};
            for (auto& step : steps) step = next();
            motion.gaze = coding::gaze_of(s.stored, s.shape, steps);
        }
        motion.coefficients.resize(Eigen::Index(s.stored.size()));
        for (float& w : motion.coefficients) w = float(next());
        if (s.shape.presence)
            motion.presence.assign(presence.begin() + std::ptrdiff_t(f) * s.shape.points,
                                   presence.begin() + std::ptrdiff_t(f + 1) * s.shape.points);
    }
    return out;
}

Result<BasisSplit> split_basis(ByteView basis) {
    MIEN_TRY(probabilities, coding::motion_basis_probabilities(basis));
    return BasisSplit{basis.size() - probabilities, probabilities};
}

}  // namespace mien::decoder
