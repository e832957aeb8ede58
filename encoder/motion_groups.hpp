#pragma once

#include <Eigen/Core>
#include <vector>

#include "coding/motion_basis.hpp"
#include "coding/motion_corrections.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// How the frames of a clip fall into groups.
struct GroupPlan {
    std::int64_t frames = 0;
    std::int64_t group_frames = 30;   ///< 0: all in one

    std::int64_t count() const { return group_frames > 0 ? (frames + group_frames - 1) / group_frames : 1; }
    std::int64_t first(std::int64_t group) const { return group * group_frames; }
    std::int64_t length(std::int64_t group) const {
        return group_frames > 0 ? std::min(group_frames, frames - first(group)) : frames;
    }
};

/// Numbers that were settled before (pose and gaze), so that a later pass codes them again as they were.
struct SettledNumbers {
    std::vector<std::vector<std::int32_t>> numbers;  ///< per channel: F coded numbers
    std::vector<std::vector<std::uint8_t>> splits;   ///< per channel: one per group
};

/// The frames of a clip as coded with one basis.
struct CodedGroups {
    std::vector<protocol::Group> groups;
    std::vector<std::uint64_t> state_hashes;         ///< after every object
    Eigen::MatrixXd samples;                         ///< channels x F as decoded, in steps
    SettledNumbers numbers;                          ///< of all channels
    Eigen::VectorXd bits;                            ///< ideal code length per channel
    double presence_bits = 0;
    double correction_bits = 0;
    std::uint64_t bytes = 0;                         ///< of all objects
    std::vector<std::uint32_t> seen;                 ///< zeros and ones per chance: for training a start
    std::vector<std::int64_t> weights;               ///< mixer weights at the groups' ends, added up
};

struct GroupOptions {
    double lambda = 0.12;                            ///< squared steps per bit
    bool choose_splits = true;                       ///< transform: try block sizes; else take them from `settled`
    bool whole_bytes = false;                        ///< causal: weigh packets by the bytes they end up with, not by ideal bits
    bool train = false;                              ///< fill `seen` and `weights`
    /// Channels below `settled_channels` are coded as `settled` has them.
    const SettledNumbers* settled = nullptr;
    int settled_channels = 0;
    /// Of the rung below, whose channels from `below_sides` on this one's first refine; null: none.
    const SettledNumbers* below = nullptr;
    int below_sides = 0;
    /// Changes of the corrections, one list per frame; null: none.
    const std::vector<std::vector<coding::MotionCorrections::Change>>* corrections = nullptr;
};

/// Codes targets (channels x F, in steps) group by group, in parallel. presence: F x N or empty.
CodedGroups code_groups(const coding::MotionBasis& basis, const coding::MotionShape& shape, const GroupPlan& plan,
                        const Eigen::MatrixXd& targets, const std::vector<std::uint8_t>& presence,
                        const GroupOptions& options);

/// A start for the entropy coder from what a pass over `groups` groups has seen: chances seen at least `fewest` times, and
/// mixer weights.
coding::MotionStart train_start(const CodedGroups& pass, std::int64_t groups, int fewest);

/// causal: linear prediction from the last three decoded values, per channel.
void train_predictors(coding::MotionBasis& basis, const GroupPlan& plan, const Eigen::MatrixXd& targets);

}  // namespace mien::encoder
