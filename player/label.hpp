#pragma once

#include <string_view>

#include "core/image.hpp"

namespace mien::player {

/// Writes one line of plain ASCII into a picture, x and y the upper left corner; scale: pixels per font pixel.
void draw_label(Image& image, int x, int y, int scale, std::string_view text);

/// Copies `tile` into `sheet` with its upper left corner at x, y; it must fit.
void paste(Image& sheet, const Image& tile, int x, int y);

}  // namespace mien::player
