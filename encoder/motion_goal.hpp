#pragma once

#include <optional>

#include "core/progress.hpp"
#include "encoder/motion_encoder.hpp"
#include "encoder/motion_search.hpp"

/// What was asked of the motion, and the coding that just meets it.
namespace mien::encoder {

/// An RMS error, a peak error, or both; or a rate.
struct MotionGoal {
    std::optional<double> rms, peak, kbps;
    protocol::MotionKind kind = protocol::MotionKind::vertices;
    bool peak_asked = false;   ///< the peak is the user's own, not what an RMS error brings with it

    /// The RMS error to expect of it, in the motion's unit.
    double guess() const { return rms ? *rms : peak ? *peak / 5 : kind == protocol::MotionKind::weights ? 0.005 : 0.1; }
};

Result<MotionGoal> goal_of(const MotionOptions& options);

struct MotionErrors {
    double rms = 0, peak = 0;     ///< mm or weight units, in the clip's own space, from the values a decoder has
};
struct MotionAnswer {
    MotionTrial trial;
    MotionErrors errors;
};

/// Fewest bits at the asked error, or smallest error at the asked rate: searches for the step. `reference`: what the offsets
/// count from. Fails when the goal cannot be met.
Result<MotionAnswer> meet(const MotionGoal& goal, const Clip& clip, const MotionTask& task, PointsRef reference,
                          const Progress& progress);

/// Whether `a` is the better answer of two that meet one goal.
bool better(const MotionGoal& goal, const MotionAnswer& a, const MotionAnswer& b);

}  // namespace mien::encoder
