#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "model/packed_columns.hpp"

namespace mien::model {

/// A motion basis ready for use: x = mean + components * w. x is the motion vector in head space: d = 3 N offsets from
/// neutral in mm (x y z of point 0, then of point 1, ...), or d = n_b weights. w: the k decoded integers of a frame,
/// as floats; steps and scales are inside `components`.
struct LinearMotion {
    Eigen::VectorXf mean;        ///< d
    Eigen::MatrixXf components;  ///< d x k
    bool corrected = false;      ///< frames may bring corrections
    /// After model::compose, for corrections: what an entry of the motion vector adds to the offsets of the drawn points, 3V x d.
    /// Empty where these are the motion vector itself.
    Eigen::SparseMatrix<float> spread{};
    /// `components` once more, as they were before they became floats: what motion_vector() adds up where there are any.
    PackedColumns packed{};

    Eigen::Index dimension() const { return mean.size(); }
    Eigen::Index size() const { return components.cols(); }
};

/// Adds `offset` to entry `at` of a vector.
struct Correction {
    std::uint32_t at = 0;
    float offset = 0;
    bool operator==(const Correction&) const = default;
};

/// One decoded instant of a motion track.
struct Motion {
    std::int64_t frame = 0;               ///< number in the stream
    Eigen::VectorXf coefficients;         ///< k, for LinearMotion::components
    std::vector<Correction> corrections;  ///< to the motion vector: entries ascending, few or none
    RigidPose pose;                       ///< head -> clip space; identity when the stream has none
    Gaze gaze;
    std::vector<std::uint8_t> presence;   ///< N, 0 = the marker was missing in the capture; empty: all present
};

/// mean + components * w + corrections: the motion vector; or, of a composed motion, the offsets of the drawn points.
Eigen::VectorXf motion_vector(const LinearMotion& basis, const Motion& motion);
/// The same added to `start` instead of `mean`, into `out`; both of d numbers.
void motion_vector(const LinearMotion& basis, const Motion& motion, const Eigen::VectorXf& start, Eigen::Ref<Eigen::VectorXf> out);

/// Adds `more` to `corrections`; entries stay ascending, each once.
void merge_corrections(std::vector<Correction>& corrections, std::span<const Correction> more);

/// Corrections of a motion vector as corrections of the drawn points' offsets, each entry once.
std::vector<Correction> drawn_corrections(const Eigen::SparseMatrix<float>& spread, std::span<const Correction> corrections);

}  // namespace mien::model
