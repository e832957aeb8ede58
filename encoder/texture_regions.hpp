#pragma once

#include <vector>

#include "media/video_encoder.hpp"

namespace mien::encoder {

/// Texel weights as quantiser offsets of 16 x 16 blocks, the unit that encoders take them in. A weighted squared error is least for
/// given bits where weight times error is the same everywhere (reverse water-filling); the error goes with the square of the
/// quantiser's step, which doubles every six, so a block of mean weight w gets -3 log2 w, within 12 up and down. Blocks of one row
/// with the same offset (in halves) are one region.
/// weights: width * height, mean 1. Regions reach to the end of their last block, beyond the texture.
std::vector<media::VideoRegion> texture_regions(const std::vector<float>& weights, int width, int height);

}  // namespace mien::encoder
