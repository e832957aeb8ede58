#pragma once

#include <Eigen/Core>

#include "coding/motion_basis.hpp"
#include "core/geometry.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// The motion of a take that was coded before, whose basis is to serve for other frames.
struct TrainingTake {
    protocol::MotionInfo info;
    coding::MotionBasis basis;         ///< as its stream has it
    Eigen::MatrixXd samples;           ///< as decoded, channels x F, in steps: pose, gaze, coefficients
    std::int64_t group_frames = 30;

    coding::MotionShape shape() const {
        return {.points = info.count, .coordinates = info.kind == protocol::MotionKind::weights ? 1u : 3u, .pose = info.has_pose,
                .gaze = info.has_gaze, .presence = info.has_presence};
    }
};

/// Gives a take of markers whose head stood still a head pose that has not moved, so that other frames may move theirs. reference: N x 3 mm.
void add_pose(TrainingTake& take, PointsRef reference);

/// The take's mean, components, pose and steps for frames coded by `scheme`: with the take's own predictors and starting chances where
/// it was coded by that scheme, else learnt from its samples.
coding::MotionBasis basis_for(const TrainingTake& take, coding::MotionScheme scheme);

}  // namespace mien::encoder
