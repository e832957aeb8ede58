#pragma once

#include <cstdint>

#include "core/clip.hpp"

namespace mien::tools {

/// The errors of design-wide use: RMS and peak of the 3-D distance over present points and frames, in the clip's own space;
/// KG = 100 |A - Â| / |A - Ā| (Karni and Gotsman 2004; Ā: each frame's mean point). Weights count as 1-D points.
class MotionError {
public:
    /// truth, received: N points of `dimension` numbers; NaN in truth: absent.
    void add(const float* truth, const float* received, std::int64_t N, int dimension);

    std::int64_t points() const { return points_; }
    double mean() const { return points_ ? distance_sum_ / double(points_) : 0; }
    double rms() const;
    double peak() const { return peak_; }
    double kg_percent() const;

private:
    std::int64_t points_ = 0;
    double distance_sum_ = 0, squared_sum_ = 0, peak_ = 0, spread_ = 0;
};

}  // namespace mien::tools
