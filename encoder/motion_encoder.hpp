#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "encoder/training_take.hpp"
#include "model/linear_motion.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// file: look-ahead inside a group. live: causal, one self-contained object per frame. guenter98: the 1998 paper's
/// scheme (order-1 prediction of the first 45 components, static codes), a baseline.
enum class MotionPreset { file, live, guenter98 };

struct MotionOptions {
    protocol::MotionKind kind = protocol::MotionKind::vertices;
    MotionPreset preset = MotionPreset::file;
    /// RMS, peak or both, or else the rate. mm for vertices and markers, weight units for weights. With an RMS error alone no point
    /// is left farther off than kUsualPeak times as much, which costs next to nothing (guenter98: no such promise).
    static constexpr double kUsualPeak = 10;
    std::optional<double> rms = 0.1;
    std::optional<double> peak;
    std::optional<double> kbps;          ///< coefficients, pose and basis together over the clip
    /// Rungs, 1 to kMaxRungs: the highest keeps the asked error, each below it twice that of the next. Errors only, and not guenter98.
    int rungs = 1;
    static constexpr int kMaxRungs = 8;
    std::int64_t group_frames = 30;      ///< frames of a group; 0: the whole clip
    /// What offsets count from, as the decoder will have it (positions may be quantised in the model); none:
    /// reference_points(clip, kind). N x 3 mm; ignored for weights.
    std::optional<Points> reference;
    const TrainingTake* training = nullptr;   ///< its motion basis is used (encode_trained); null: one is made for the clip
    std::vector<std::uint32_t> mirror;   ///< Mesh::mirror of the neutral mesh as the decoder will have it, for vertices; or empty
};

/// A rung that refines the one before it.
struct MotionRefinement {
    Bytes basis;
    std::vector<protocol::Group> groups;       ///< slot 0, in order, of the same frames as those of the lowest rung
    std::vector<std::uint64_t> state_hashes;
    double rms = 0, peak = 0;                  ///< with this rung and those below
};

struct EncodedMotion {
    protocol::MotionInfo info;
    Bytes basis;                               ///< motion_basis blob, unpacked; of the lowest rung, as all here
    std::vector<protocol::Group> groups;       ///< slot 0, in order
    std::vector<std::uint64_t> state_hashes;   ///< entropy coder's state after every object, for tests
    double rms = 0, peak = 0;                  ///< measured from a decode, mm or weight units
    std::vector<MotionRefinement> refinements; ///< lowest first
    /// Where the bits of all rungs go: bytes of the basis (probabilities apart) and of the objects, and ideal bits of the latter.
    struct Bits {
        double basis = 0, probabilities = 0, coefficients = 0, pose = 0;  ///< coefficients with corrections; pose with gaze and presence
        double total() const { return basis + probabilities + coefficients + pose; }
    } bits;
};

/// Encodes the motion of `options.kind` in `clip`. Fails, saying why, when the asked error cannot be met.
Result<EncodedMotion> encode_motion(const Clip& clip, const MotionOptions& options, const Progress& progress = {});

}  // namespace mien::encoder
