#pragma once

#include <vector>

#include "media/ffmpeg.hpp"

namespace mien::media {

/// Appends a decoded sound frame as interleaved floats in [-1, 1]. False for a sample format nobody decodes
/// to.
bool append_samples(const AVFrame& frame, std::vector<float>& samples);

}  // namespace mien::media
