#pragma once

#include <Eigen/Cholesky>
#include <optional>

#include "core/geometry.hpp"
#include "encoder/training_take.hpp"

namespace mien::encoder {

/// One instant of motion as it was captured.
struct MotionFrame {
    Eigen::VectorXf values;              ///< markers or vertices x y z, mm, in the clip's space, three NaNs for a missing one; or weights
    std::optional<RigidPose> pose;       ///< of the head, when it is known
    std::optional<Gaze> gaze;
};

/// Frames as numbers of a basis that was not made for them. Looks at one frame after the other, never ahead.
class FrameProjector {
public:
    /// take, basis and reference (N x 3 mm; ignored for weights) outlive it.
    FrameProjector(const TrainingTake& take, const coding::MotionBasis& basis, PointsRef reference);

    /// Pose and gaze in steps, less their means. A pose that is not known is fitted to the points that stood still in the take; a frame
    /// without three of them keeps the pose before.
    Eigen::VectorXd sides(const MotionFrame& frame);
    /// Coefficients in steps, the best for the pose as it is decoded (in sixteenths of a step, less the mean). What missing markers leave open
    /// stays near the frame before.
    Eigen::VectorXd coefficients(const MotionFrame& frame, const Eigen::VectorXd& decoded_sides);

    /// How far a decoded frame (channels, in steps) is from the truth, over present points.
    struct Errors {
        double squared = 0, peak = 0;    ///< mm or weight units
        std::int64_t points = 0;
    };
    Errors errors(const MotionFrame& frame, const Eigen::VectorXd& decoded) const;

    const coding::MotionShape& shape() const { return shape_; }

private:
    RigidPose decoded_pose(const Eigen::VectorXd& sides) const;

    const coding::MotionBasis& basis_;
    coding::MotionShape shape_;
    const Points reference_;
    Eigen::VectorXd mean_;
    Eigen::MatrixXd columns_;            ///< d x k, per step
    Eigen::MatrixXd gram_;
    Eigen::LDLT<Eigen::MatrixXd> solver_;  ///< of all points
    Eigen::VectorXf steadiness_;         ///< N, weights of the pose's fit
    RigidPose pose_;                     ///< of the frame before
    Eigen::VectorXd last_;               ///< coefficients of the frame before
};

}  // namespace mien::encoder
