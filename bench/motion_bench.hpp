#pragma once

#include <string>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "encoder/motion_encoder.hpp"

namespace mien::bench {

/// One codec on one clip, as stored, without framing.
struct MotionRow {
    std::string codec;
    double basis = 0, probabilities = 0, coefficients = 0, pose = 0;  ///< kbit/s
    double kbps = 0;
    double entropy_kbps = 0;             ///< guenter98: order-0 entropies of all numbers, the paper's own figure; else 0
    double rms = 0, peak = 0;            ///< re-measured from a decode of the bytes
    std::uint32_t components = 0;
    double encode_seconds = 0;
    double decode_seconds = 0;           ///< one core, ending in float positions, best of several runs
};

/// Encodes, decodes with a fresh decoder, measures in the clip's own space.
Result<MotionRow> bench_motion(const Clip& clip, const encoder::MotionOptions& options, const std::string& name);

/// Draco's mesh codec on single frames of a vertex clip.
struct DracoTiming {
    double bytes_per_frame = 0;
    double seconds_per_frame = 0;
    int quantisation_bits = 0;
};
/// Position precision is the coarsest whose error is at most `rms`. Frames are spread over the clip.
DracoTiming bench_draco(const Clip& clip, double rms, int frames);

}  // namespace mien::bench
