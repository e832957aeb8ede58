#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/rational.hpp"
#include "core/result.hpp"

namespace mien::io {

/// Which frame every row of a recording is, found from its times: gaps show as frames without a row.
struct FrameTimes {
    std::vector<std::int64_t> frame_of_row;  ///< ascending from 0; equal to the one before where a time repeats
    double step = 0;                         ///< mean time between neighbours where nothing was dropped; 0 for a single row
    std::int64_t frames() const { return frame_of_row.empty() ? 0 : frame_of_row.back() + 1; }
};

/// `times`: ascending, in any unit. Errors (invalid, message begins with "row N"): time runs backwards or jumps by more than
/// `longest_gap`.
Result<FrameTimes> number_frames(const std::vector<double>& times, double longest_gap);

/// The usual frame rate nearest to `measured` (Hz), within half a percent; else `measured` in thousandths; nothing for what is no frame rate.
std::optional<Rational> usual_rate(double measured);

}  // namespace mien::io
