#pragma once

#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "core/result.hpp"

namespace mien::bench {

/// One frame of a clip from the front, drawn with the true texture and then with that of each codec at one rate, side by side:
/// above the whole head, below the part between brows and chin twice as large. Motion is the truth's in all.
/// clip: with a neutral mesh, vertices and a texture video. Throws EnvironmentError without OpenGL.
Result<Image> picture_row(const Clip& clip, const std::vector<std::string>& codecs, double kbps, std::int64_t frame,
                          const Progress& progress = {});

}  // namespace mien::bench
