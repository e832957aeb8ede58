#pragma once

#include <cstdint>

#include "core/progress.hpp"
#include "core/result.hpp"
#include "encoder/motion_encoder.hpp"

namespace mien::bench {

/// What the motion codec takes for a clip: to train a basis, to code frames once the basis is known, to read its numbers.
struct MotionTimes {
    std::int64_t frames = 0, points = 0, components = 0;
    int threads = 0;
    double training = 0;          ///< s: the basis found and written and the whole clip coded, by all threads
    double rms = 0;               ///< of the clip as it was coded then
    std::int64_t known_frames = 0;
    double known = 0, known_median = 0;   ///< processor s of one thread: known_frames together, and the median frame; each coded by itself as it comes
    double known_rms = 0;
    std::uint64_t known_bytes = 0;
    std::int64_t decisions = 0;   ///< binary ones, in all frames of the clip
    std::uint64_t frame_bytes = 0;
    double decision = 0;          ///< median processor s of reading one, with the predictions and transforms between them
    std::int64_t coder_decisions = 0;   ///< those of them that are of coded integers; 0: not measured (`live`)
    double coder = 0;             ///< median processor s of reading one of these by the entropy coder alone: contexts known, a group's model at hand
};

/// Trains on the clip, then codes its first `known` frames live with that basis, and reads the clip's numbers `rounds` times. The last two on
/// one thread: set_thread_count() is left at the machine's cores. options.preset: of the training, `file` or `live`.
Result<MotionTimes> time_motion(const Clip& clip, const encoder::MotionOptions& options, std::int64_t known, int rounds, const Progress& progress = {});

}  // namespace mien::bench
