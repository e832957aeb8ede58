#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/clip.hpp"

namespace mien::encoder {

/// Head pose of every frame: the rigid motion that brings `reference` (N x 3) closest to the frame's steadiest points.
/// rigid: the points known to move with the skull; empty: found by giving points weight 1 / (squared residual), again and
/// again. Points that are NaN in either place have no say; a frame without three points keeps the pose before.
std::vector<RigidPose> steady_poses(const PointSequence& sequence, PointsRef reference,
                                    std::span<const std::uint32_t> rigid);

/// How far the steadiest eighth of the points strays from `reference` when no pose is removed: RMS, mm.
double steadiest_stray(const PointSequence& sequence, PointsRef reference);

}  // namespace mien::encoder
