#include "analysis/frame_values.hpp"

#include <algorithm>
#include <cassert>

namespace mien::analysis {

FrameValues::FrameValues(std::int64_t frames, int values, std::size_t texels, std::int64_t lanes, std::size_t most_bytes)
    : values_(values), texels_(texels), lanes_(static_cast<std::size_t>(lanes)) {
    const std::size_t bytes = std::max<std::size_t>(1, std::size_t(values) * texels * sizeof(float));
    frames_.resize(std::min(std::size_t(frames), most_bytes / bytes));
}

float* FrameValues::write(std::int64_t frame, std::int64_t lane) {
    assert(!kept(frame));
    std::vector<float>& place = frame < std::int64_t(frames_.size()) ? frames_[std::size_t(frame)] : lanes_[std::size_t(lane)];
    place.resize(std::size_t(values_) * texels_);
    return place.data();
}

const float* FrameValues::read(std::int64_t frame, std::int64_t lane) const {
    return (frame < std::int64_t(frames_.size()) ? frames_[std::size_t(frame)] : lanes_[std::size_t(lane)]).data();
}

void FrameValues::keep(const std::vector<std::uint32_t>& texels) {
    for (std::vector<float>& frame : frames_) {
        if (frame.empty()) continue;
        std::vector<float> rest(std::size_t(values_) * texels.size());
        for (std::size_t v = 0; v < std::size_t(values_); ++v)
            for (std::size_t i = 0; i < texels.size(); ++i) rest[v * texels.size() + i] = frame[v * texels_ + texels[i]];
        frame = std::move(rest);
    }
    texels_ = texels.size();
}

}  // namespace mien::analysis
