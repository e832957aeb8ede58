#pragma once

#include <memory>

#include "core/mesh.hpp"
#include "core/result.hpp"
#include "encoder/frame_projector.hpp"

namespace mien::encoder {

/// Codes motion frame by frame as it is captured, with the basis of a training take: one object per frame, no look-ahead, the same bits as the
/// preset `live` makes of the same numbers.
class LiveMotion {
public:
    /// reference: what offsets count from, N x 3 mm, as the decoder's model has it; ignored for weights. step: of the coefficients, mm or weight
    /// units over all points; none: the take's own. triangles, mirror: of the take's neutral mesh, where its basis needs them.
    LiveMotion(const TrainingTake& take, PointsRef reference, std::optional<float> step = {}, std::span<const Triangle> triangles = {},
               std::span<const std::uint32_t> mirror = {});
    ~LiveMotion();

    /// Of the track: the take's, and markers may be missing.
    const protocol::MotionInfo& info() const;
    const Bytes& basis() const;                      ///< motion_basis blob, unpacked
    std::size_t probability_bytes() const;           ///< of these

    /// A decoder can begin with the next frame.
    void begin_group();
    /// Refuses a frame of another size and numbers that are none, naming the point; the frames around it are not touched.
    Result<protocol::Object> encode(const MotionFrame& frame);

    /// Since the start.
    struct Figures {
        std::int64_t frames = 0;
        double rms = 0, peak = 0;                    ///< of decoded frames, mm or weight units
        double pose_bits = 0, coefficient_bits = 0;  ///< ideal; pose includes gaze and presence
        std::uint64_t bytes = 0;                     ///< of all objects
    };
    Figures figures() const;
    /// Of the last frame, as a decoder has it: channels in sixteenths of a step.
    const std::vector<std::int64_t>& samples() const;
    std::uint64_t state_hash() const;                ///< of the entropy coder after the last frame

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Whether a frame can be coded at all: size, finite numbers, no marker half missing. N points of `coordinates` numbers.
Result<void> check_frame(const MotionFrame& frame, const protocol::MotionInfo& info);

}  // namespace mien::encoder
