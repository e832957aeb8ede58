#pragma once

#include <vector>

#include "encoder/motion_groups.hpp"
#include "encoder/motion_matrix.hpp"
#include "model/linear_motion.hpp"

namespace mien::encoder {

/// Which points are corrected where, so that none is farther off than asked.
struct CorrectionPlan {
    std::vector<std::uint32_t> points;   ///< ascending: MotionBasis::corrected
    double step = 1;                     ///< of the corrections
    std::vector<std::vector<coding::MotionCorrections::Change>> changes;   ///< per frame
};

/// Few changes that hold every present point of every frame within `peak` of `motion`, given what the components say.
/// A correction is held until the error leaves the ball of radius `peak` around it; with `look_ahead` the next one is that which
/// lasts longest, else the nearest. Where none is needed any more it is held on until it has added more squared error than `price`, what a
/// change is worth: a group may be the whole clip.
CorrectionPlan plan_corrections(const MotionMatrix& motion, const coding::MotionBasis& basis, const CodedGroups& coded,
                                const GroupPlan& plan, std::uint32_t coordinates, double peak, double price, bool look_ahead);

/// What holds in each frame after `changes`.
std::vector<std::vector<model::Correction>> held_corrections(const coding::MotionBasis& basis, const GroupPlan& plan, std::uint32_t coordinates,
                                                             const std::vector<std::vector<coding::MotionCorrections::Change>>& changes);

}  // namespace mien::encoder
