#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"
#include "model/linear_motion.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// file: look-ahead inside a group. live: causal, one self-contained object per frame. guenter98: the 1998 paper's
/// scheme (order-1 prediction of the first 45 components, static codes), a baseline.
enum class MotionPreset { file, live, guenter98 };

struct MotionOptions {
    protocol::MotionKind kind = protocol::MotionKind::vertices;
    MotionPreset preset = MotionPreset::file;
    /// Exactly one of the three is set. mm for vertices and markers, weight units for weights.
    std::optional<double> rms = 0.1;
    std::optional<double> peak;
    std::optional<double> kbps;          ///< coefficients, pose and basis together over the clip
    std::int64_t group_frames = 30;      ///< frames of a group; 0: the whole clip
    /// What offsets count from, as the decoder will have it (positions may be quantised in the model); none:
    /// reference_points(clip, kind). N x 3 mm; ignored for weights.
    std::optional<Points> reference;
    std::vector<std::uint32_t> mirror;   ///< Mesh::mirror of the neutral mesh as the decoder will have it, for vertices; or empty
};

struct EncodedMotion {
    protocol::MotionInfo info;
    Bytes basis;                               ///< motion_basis blob, unpacked
    std::vector<protocol::Group> groups;       ///< slot 0, in order
    std::vector<std::uint64_t> state_hashes;   ///< entropy coder's state after every object, for tests
    double rms = 0, peak = 0;                  ///< measured from a decode, mm or weight units
    /// Where the bits go: bytes of the basis (probabilities apart) and of the objects, and ideal bits of the latter.
    struct Bits {
        double basis = 0, probabilities = 0, coefficients = 0, pose = 0;  ///< pose includes gaze and presence
        double total() const { return basis + probabilities + coefficients + pose; }
    } bits;
};

/// Encodes the motion of `options.kind` in `clip`. Fails, saying why, when the asked error cannot be met.
Result<EncodedMotion> encode_motion(const Clip& clip, const MotionOptions& options, const Progress& progress = {});

}  // namespace mien::encoder
