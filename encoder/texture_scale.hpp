#pragma once

#include "core/image.hpp"

namespace mien::encoder {

/// `picture` with width x height pixels, at most its own: each the mean of what it covers, whole or in part. Integer-only.
Image scaled_down(const Image& picture, int width, int height);

}  // namespace mien::encoder
