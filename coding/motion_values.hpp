#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "coding/motion_basis.hpp"
#include "coding/motion_frames.hpp"
#include "core/geometry.hpp"

/// From decoded integers to floats: the one place where a motion stream leaves the integers. Encoder and decoder share it,
/// so what the encoder measures is what a player shows.
namespace mien::coding {

/// d: mean of the motion vector.
Eigen::VectorXf mean_of(const MotionBasis& basis);

/// k: what an integer of each component counts for a coefficient that counts sixteenths of a step.
std::vector<double> component_scales(const MotionBasis& basis);
/// d x k: the components by their scales.
Eigen::MatrixXf components_of(const MotionBasis& basis);

/// What a coefficient of rung `low` counts in the columns of a rung `high` above it, which begin with the same vectors.
inline float scale_between(const MotionBasis& low, const MotionBasis& high) { return float(double(low.step) / double(high.step)); }

/// Length of an integer vector; 0 for a vector of zeros.
double length_of(std::span<const std::int32_t> vector);

/// Pose and gaze as the numbers that are coded, in steps.
std::array<double, 6> pose_steps(const MotionBasis& basis, const RigidPose& pose);
std::array<double, 4> gaze_steps(const MotionBasis& basis, const Gaze& gaze);

/// ... and back, from samples in sixteenths (side_mean not yet added).
RigidPose pose_of(const MotionBasis& basis, const std::array<std::int64_t, 6>& samples);
Gaze gaze_of(const MotionBasis& basis, const MotionShape& shape, const std::array<std::int64_t, 4>& samples);

}  // namespace mien::coding
