#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mien::analysis {

/// What a layer is to explain, frame by frame: [values][texels] floats each. The first frames are kept, as many as `most_bytes` hold, so
/// that going through all frames again need not read and measure their scans again; the others share one place per lane.
class FrameValues {
public:
    FrameValues(std::int64_t frames, int values, std::size_t texels, std::int64_t lanes, std::size_t most_bytes);

    bool kept(std::int64_t frame) const { return frame < std::int64_t(frames_.size()) && !frames_[std::size_t(frame)].empty(); }
    /// Where to write a frame that is not kept yet, values * texels; from then on it is, if it is among the first. Other frames may be
    /// written at the same time on other lanes.
    float* write(std::int64_t frame, std::int64_t lane);
    const float* read(std::int64_t frame, std::int64_t lane) const;
    void keep(const std::vector<std::uint32_t>& texels);  ///< drops all others; ascending

private:
    int values_;
    std::size_t texels_;
    std::vector<std::vector<float>> frames_, lanes_;
};

}  // namespace mien::analysis
