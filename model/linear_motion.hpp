#pragma once

#include <Eigen/Core>

#include "core/geometry.hpp"

namespace mien::model {

/// A motion basis ready for use: x = mean + components * w. x is the motion vector in head space: d = 3 N offsets from
/// neutral in mm (x y z of point 0, then of point 1, ...), or d = n_b weights. w: the k decoded integers of a frame,
/// as floats; steps and scales are inside `components`.
struct LinearMotion {
    Eigen::VectorXf mean;        ///< d
    Eigen::MatrixXf components;  ///< d x k

    Eigen::Index dimension() const { return mean.size(); }
    Eigen::Index size() const { return components.cols(); }
};

/// One decoded instant of a motion track.
struct Motion {
    std::int64_t frame = 0;               ///< number in the stream
    Eigen::VectorXf coefficients;         ///< k, for LinearMotion::components
    RigidPose pose;                       ///< head -> clip space; identity when the stream has none
    Gaze gaze;
    std::vector<std::uint8_t> presence;   ///< N, 0 = the marker was missing in the capture; empty: all present
};

}  // namespace mien::model
