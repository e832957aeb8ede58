#include "player/label.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmisleading-indentation"
#include <stb_easy_font.h>
#pragma GCC diagnostic pop

namespace mien::player {

void draw_label(Image& image, int x, int y, int scale, std::string_view text) {
    struct Corner {
        float x, y, z;
        unsigned char colour[4];
    };
    std::array<Corner, 4 * 2048> corners;   // stb_easy_font: about 68 corners a letter
    std::string line(text.substr(0, 100));
    const int quads = stb_easy_font_print(0, 0, line.data(), nullptr, corners.data(), int(sizeof corners));
    for (int q = 0; q < quads; ++q) {
        const Corner &a = corners[4 * q], &c = corners[4 * q + 2];
        const int x0 = std::clamp(x + int(std::lround(a.x * scale)), 0, image.width);
        const int x1 = std::clamp(x + int(std::lround(c.x * scale)), 0, image.width);
        const int y0 = std::clamp(y + int(std::lround(a.y * scale)), 0, image.height);
        const int y1 = std::clamp(y + int(std::lround(c.y * scale)), 0, image.height);
        for (int row = y0; row < y1; ++row)
            for (int column = x0; column < x1; ++column) std::memset(image.at(column, row), 225, std::size_t(image.channels));
    }
}

void paste(Image& sheet, const Image& tile, int x, int y) {
    assert(sheet.channels == tile.channels && x >= 0 && y >= 0 && x + tile.width <= sheet.width && y + tile.height <= sheet.height);
    for (int row = 0; row < tile.height; ++row)
        std::memcpy(sheet.at(x, y + row), tile.at(0, row), std::size_t(tile.width) * tile.channels);
}

}  // namespace mien::player
