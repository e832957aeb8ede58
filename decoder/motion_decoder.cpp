#include "decoder/motion_decoder.hpp"

#include "coding/motion_basis.hpp"
#include "coding/motion_corrections.hpp"
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

/// Integers of one rung.
struct MotionRung {
    MotionRung(coding::MotionBasis stored_, const coding::MotionShape& shape_)
        : stored(std::move(stored_)), shape(shape_), frames(stored, shape), corrections(stored, shape) {}

    void begin_group() {
        frames.begin_group();
        corrections.begin_group();
        broken = false;
    }

    Result<void> check(const protocol::Object& object) const {
        const std::uint64_t n = object.frames, most = coding::MotionFrames::kMaxSamples;
        if (n == 0 || n > coding::MotionFrames::kMaxFrames || n * std::uint64_t(frames.layout().total() + 1) > most ||
            (shape.presence && n * shape.points > most) || n * stored.corrected.size() * shape.coordinates > most ||
            object.bytes.size() > protocol::kMaxObjectBytes)
            return Error{ErrorCode::limit_exceeded, "a motion object of " + std::to_string(n) + " frames"};
        // Every number is a decision at least: a few bytes cannot make room for more of them than they can hold.
        if (n * std::uint64_t(frames.layout().total()) > coding::most_decisions(object.bytes.size()))
            return Error{ErrorCode::limit_exceeded, "a motion object of " + std::to_string(n) + " frames in " + std::to_string(object.bytes.size()) + " bytes"};
        return {};
    }

    /// The corrections of an object, which follow its channels.
    void correct(coding::MeteredDecoder& coder, std::span<model::Motion> motions) {
        if (stored.corrected.empty()) return;
        coder.enter(false);
        std::vector<coding::MotionCorrections::Change> changes;
        for (model::Motion& motion : motions) {
            corrections.code(coder, changes);
            if (coder.failed()) return;
            const auto values = corrections.values();
            for (std::size_t i = 0; i < values.size(); ++i)
                if (values[i] != 0)
                    motion.corrections.push_back({std::uint32_t(stored.corrected[i / shape.coordinates] * shape.coordinates + i % shape.coordinates),
                                                  float(values[i]) * stored.correction_step});
        }
    }

    coding::MotionBasis stored;
    coding::MotionShape shape;
    coding::MotionFrames frames;
    coding::MotionCorrections corrections;
    bool broken = false;
};

}  // namespace

struct MotionDecoder::State {
    std::vector<std::unique_ptr<MotionRung>> rungs;   // lowest first
    model::LinearMotion basis;
    std::uint64_t digest = 0;
    std::size_t refined = 0;
    Split split;

    bool decode(MotionRung& rung, const protocol::Object& object, std::vector<model::Motion>& out, std::vector<std::uint8_t>& presence);
};

Result<MotionDecoder> MotionDecoder::create(const protocol::MotionInfo& info, std::span<const ByteView> bases,
                                            std::span<const Triangle> triangles, std::span<const std::uint32_t> mirror) {
    if (info.count == 0 || info.count > most_points(info.kind))
        return Error{ErrorCode::limit_exceeded, "a motion track of " + std::to_string(info.count) + " points"};
    coding::MotionShape shape = shape_of(info);
    auto state = std::make_unique<State>();
    for (const ByteView bytes : bases) {
        const coding::MotionBasis* below = state->rungs.empty() ? nullptr : &state->rungs.back()->stored;
        MIEN_TRY(stored, coding::read_motion_basis(shape, bytes, triangles, mirror, below));
        const Eigen::VectorXf mean = coding::mean_of(stored);
        if (below) state->basis.mean += mean;
        else state->basis.mean = mean;
        state->basis.corrected |= !stored.corrected.empty();
        state->rungs.push_back(std::make_unique<MotionRung>(std::move(stored), shape));
        shape.pose = shape.gaze = shape.presence = false;   // those are the lowest rung's
    }
    if (state->rungs.empty()) return Error{ErrorCode::missing, "no motion basis"};
    const coding::MotionBasis& highest = state->rungs.back()->stored;
    state->basis.components = coding::components_of(highest);
    state->basis.packed = model::PackedColumns::pack(highest.components, coding::component_scales(highest));
    // Only lengths and steps matter from here on.
    for (auto& rung : state->rungs)
        for (auto& component : rung->stored.components) component = {};
    return MotionDecoder(std::move(state));
}

MotionDecoder::MotionDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
MotionDecoder::MotionDecoder(MotionDecoder&&) noexcept = default;
MotionDecoder& MotionDecoder::operator=(MotionDecoder&&) noexcept = default;
MotionDecoder::~MotionDecoder() = default;

const model::LinearMotion& MotionDecoder::basis() const { return state_->basis; }
std::uint64_t MotionDecoder::state_hash() const { return state_->digest; }
MotionDecoder::Split MotionDecoder::split() const { return state_->split; }
std::size_t MotionDecoder::rungs() const { return state_->rungs.size(); }
std::size_t MotionDecoder::refined() const { return state_->refined; }

void MotionDecoder::begin_group() {
    for (auto& rung : state_->rungs) rung->begin_group();
}

// One object of one rung: its integers, and its corrections. False when it is damaged.
bool MotionDecoder::State::decode(MotionRung& rung, const protocol::Object& object, std::vector<model::Motion>& out,
                                  std::vector<std::uint8_t>& presence) {
    coding::MeteredDecoder coder(object.bytes);
    coder.enter(true);
    if (rung.shape.presence) rung.frames.code_presence(coder, object.frames, presence);
    rung.frames.decode(coder, object.frames);
    rung.correct(coder, out);
    if (!coder.complete()) return false;
    digest = coder.digest();
    const double ideal = coder.bits(true) + coder.bits(false);
    if (ideal > 0) {
        const double scale = double(object.bytes.size()) * 8 / ideal;
        split.pose += coder.bits(true) * scale;
        split.coefficients += coder.bits(false) * scale;
    }
    return true;
}

Result<std::vector<model::Motion>> MotionDecoder::decode(const protocol::Object& object, std::int64_t first_frame,
                                                         std::span<const protocol::Object* const> refinements) {
    State& s = *state_;
    MotionRung& lowest = *s.rungs.front();
    const auto refuse = [&](Error error) {
        lowest.broken = true;
        return error;
    };
    if (lowest.broken) return Error{ErrorCode::damaged, "motion: an earlier object of this group was damaged"};
    if (auto fits = lowest.check(object); !fits.ok()) return refuse(fits.error());
    const std::uint32_t n = object.frames;
    std::vector<model::Motion> out(n);
    std::vector<std::uint8_t> presence;
    if (!s.decode(lowest, object, out, presence))
        return refuse({ErrorCode::damaged, "motion: the object of frame " + std::to_string(first_frame) + " does not end where it should"});

    const Eigen::Index columns = s.basis.size();
    const coding::MotionBasis& highest = s.rungs.back()->stored;
    for (std::uint32_t f = 0; f < n; ++f) {
        model::Motion& motion = out[f];
        motion.frame = first_frame + f;
        int channel = 0;
        const auto next = [&] { return lowest.frames.sample(channel++, f, n); };
        if (lowest.shape.pose) {
            std::array<std::int64_t, 6> steps{};
            for (auto& step : steps) step = next();
            motion.pose = coding::pose_of(lowest.stored, steps);
        }
        if (lowest.shape.gaze) {
            std::array<std::int64_t, 4> steps{};
            for (auto& step : steps) step = next();
            motion.gaze = coding::gaze_of(lowest.stored, lowest.shape, steps);
        }
        motion.coefficients.setZero(columns);
        if (lowest.shape.presence)
            motion.presence.assign(presence.begin() + std::ptrdiff_t(f) * lowest.shape.points,
                                   presence.begin() + std::ptrdiff_t(f + 1) * lowest.shape.points);
    }
    const auto add = [&](const MotionRung& rung) {
        const float scale = coding::scale_between(rung.stored, highest);
        const int side = rung.frames.layout().side();
        for (std::uint32_t f = 0; f < n; ++f)
            for (std::uint32_t c = 0; c < rung.stored.size(); ++c)
                out[f].coefficients[c] += scale * float(rung.frames.sample(side + int(c), f, n));
    };
    add(lowest);
    s.refined = 1;
    for (std::size_t r = 1; r < s.rungs.size(); ++r) {
        MotionRung& rung = *s.rungs[r];
        const MotionRung& below = *s.rungs[r - 1];
        const protocol::Object* refinement = r <= refinements.size() ? refinements[r - 1] : nullptr;
        rung.broken |= !refinement || refinement->frames != n || !rung.check(*refinement).ok();
        std::vector<model::Motion> corrected(rung.broken ? 0 : n);
        if (!rung.broken) {
            coding::MotionFrames::Below numbers;
            for (std::uint32_t c = 0; c < rung.stored.shared; ++c) {
                const int channel = below.frames.layout().side() + int(c);
                numbers.numbers.push_back(below.frames.numbers(channel, n).data());
                numbers.splits.push_back(std::uint8_t(below.frames.split(channel)));
            }
            rung.frames.set_below(std::move(numbers));
            rung.broken = !s.decode(rung, *refinement, corrected, presence);
        }
        // What stands on a rung that is not there would be meant for other frames.
        if (rung.broken) {
            for (; r < s.rungs.size(); ++r) s.rungs[r]->broken = true;
            break;
        }
        add(rung);
        for (std::uint32_t f = 0; f < n; ++f) model::merge_corrections(out[f].corrections, corrected[f].corrections);
        s.refined = r + 1;
    }
    return out;
}

Result<BasisSplit> split_basis(ByteView basis) {
    MIEN_TRY(probabilities, coding::motion_basis_probabilities(basis));
    return BasisSplit{basis.size() - probabilities, probabilities};
}

}  // namespace mien::decoder
