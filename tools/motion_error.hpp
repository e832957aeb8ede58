#pragma once

#include <cstdint>
#include <vector>

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

/// The RMS error of showing each point's mean over all frames instead: F frames of N points of `dimension` numbers, NaN: absent.
double still_rms(const std::vector<float>& values, std::int64_t N, int dimension);

}  // namespace mien::tools
