#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/mesh.hpp"
#include "core/result.hpp"
#include "model/linear_motion.hpp"
#include "protocol/stream.hpp"

namespace mien::decoder {

/// Turns the objects of a motion rung, and of the rungs it refines, into motion. Not thread-safe; one per stream.
/// Whatever the bytes are: a basis or an object of b bytes is given up after coding::most_decisions(b) decisions and those of one frame's
/// presence, one block or 256 points; an object may announce no more numbers (channels x frames) than that, nor more than
/// MotionFrames::kMaxSamples of numbers, presences or corrections, and a basis no more than MotionBasis::kMaxValues.
class MotionDecoder {
public:
    /// `bases`: the unpacked motion_basis blobs of the rungs, the one that stands alone first. Refuses those that do not fit `info`
    /// or each other. `triangles`: of the model's neutral mesh, when it has one: bases of vertex motion are predicted across it
    /// (ErrorCode::missing without), and from side to side with its `mirror`.
    static Result<MotionDecoder> create(const protocol::MotionInfo& info, std::span<const ByteView> bases,
                                        std::span<const Triangle> triangles = {}, std::span<const std::uint32_t> mirror = {});
    /// The same for one rung that stands alone.
    static Result<MotionDecoder> create(const protocol::MotionInfo& info, ByteView basis,
                                        std::span<const Triangle> triangles = {}, std::span<const std::uint32_t> mirror = {}) {
        return create(info, std::span(&basis, 1), triangles, mirror);
    }
    MotionDecoder(MotionDecoder&&) noexcept;
    MotionDecoder& operator=(MotionDecoder&&) noexcept;
    ~MotionDecoder();

    const model::LinearMotion& basis() const;

    /// Forgets everything predicted from; call before the first object of every group.
    void begin_group();

    /// Decodes the next object of the group: `object.frames` instants, numbered from `first_frame`. After an error the
    /// decoder waits for begin_group() and refuses objects until then.
    /// refinements: the objects of the same frames in the rungs above, lowest first. Those behind one that is null, damaged or of
    /// other frames are left out, to the group's end, and so is it: refined() tells.
    Result<std::vector<model::Motion>> decode(const protocol::Object& object, std::int64_t first_frame,
                                              std::span<const protocol::Object* const> refinements = {});

    /// Rungs that this decoder was made for, and how many of them took part in the last decode().
    std::size_t rungs() const;
    std::size_t refined() const;

    /// The entropy decoder's state after the last object (of the highest rung that took part); equal to the encoder's, or something has drifted.
    std::uint64_t state_hash() const;

    /// Bits of the objects decoded so far by what they carried (ideal code lengths, scaled to the real bytes).
    struct Split {
        double coefficients = 0, pose = 0;  ///< bits; pose includes gaze and presence
    };
    Split split() const;

private:
    struct State;
    explicit MotionDecoder(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Sizes of the parts of a motion basis blob, bytes: for `mien info`.
struct BasisSplit {
    std::uint64_t basis = 0;          ///< mean, components, steps, predictors
    std::uint64_t probabilities = 0;
};
Result<BasisSplit> split_basis(ByteView basis);

}  // namespace mien::decoder
