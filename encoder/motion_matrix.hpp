#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// The motion vectors of a clip, one frame per column: offsets from the reference points in head space, or weights.
struct MotionMatrix {
    Eigen::MatrixXf values;                 ///< d x F; missing markers are filled with a guess
    std::vector<std::uint8_t> presence;     ///< F x N, 0 = missing; empty: all present
    std::int64_t present = 0;               ///< points (weights) present in all frames together: what errors are averaged over
};

/// Refuses infinity, NaN where no marker may be missing, and an empty sequence, naming frame and point.
Result<void> check_motion(const Clip& clip, protocol::MotionKind kind);

/// True when the clip has markers that are missing in some frames.
bool has_missing_markers(const Clip& clip);

/// clip passed check_motion(); poses: one per frame, or empty.
MotionMatrix motion_matrix(const Clip& clip, protocol::MotionKind kind, PointsRef reference,
                           const std::vector<RigidPose>& poses);

/// Replaces the guesses for missing markers by what the other markers and frames say: a low-rank fit, again and again.
void impute(MotionMatrix& matrix);

}  // namespace mien::encoder
