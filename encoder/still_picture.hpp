#pragma once

#include "core/clip.hpp"
#include "core/progress.hpp"

namespace mien::encoder {

/// One picture for a face whose texture will not move: the clip's first, but teeth and lining of the mouth (by the neutral mesh's
/// surfaces) as they look in the frame that shows each texel brightest. A first frame has its mouth shut, and what lies behind the
/// lips is dark in it; light can only be taken from what a texel is, never added. At most some hundred frames are read, evenly spread.
/// The clip must have a texture and a neutral mesh with texture coordinates.
Result<Image> still_picture(const Clip& clip, const Progress& progress = {});

}  // namespace mien::encoder
