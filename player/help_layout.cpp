#include "player/help_layout.hpp"

#include <algorithm>

namespace mien::player {

HelpLayout fit_help(float width, float height, int entries, float column_width, float row_height) {
    HelpLayout best{2, (entries + 1) / 2, 0.25f};   // smaller letters nobody can read
    for (const int columns : {2, 1, 3, 4}) {
        const int rows = (entries + columns - 1) / columns;
        const float scale = std::min({1.0f, width / (float(columns) * column_width), height / (float(rows) * row_height)});
        if (scale > best.scale) best = {columns, rows, scale};
    }
    return best;
}

}  // namespace mien::player
