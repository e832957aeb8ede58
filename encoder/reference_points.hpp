#pragma once

#include "core/clip.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// The positions that motion of `kind` is an offset from, N x 3 mm, head space: the neutral mesh's vertices, or the neutral
/// positions of the marker sites; without those, the mean over all frames of the points with their head pose removed,
/// rounded to 1/64 mm so that it can be stored exactly. Empty for weights.
Points reference_points(const Clip& clip, protocol::MotionKind kind);

}  // namespace mien::encoder
