#pragma once

#include "core/clip.hpp"

namespace mien::bench {

/// The first `frames` frames of a clip, without sound; the whole clip when it has no more.
Clip first_frames(const Clip& clip, std::int64_t frames);

/// A small clip that is always there: a waving sheet of 400 vertices with a moving texture of 64 x 64, 12 frames at 12 Hz.
Clip sheet_clip();

/// Names what was measured: a hash over motion, mesh, frame rate and the texture's size and first picture.
std::string clip_key(const Clip& clip);

}  // namespace mien::bench
