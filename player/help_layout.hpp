#pragma once

namespace mien::player {

/// How the keys of the help are set into a window: columns of equal width, and what their letters are scaled by.
struct HelpLayout {
    int columns = 1, rows = 0;
    float scale = 1;   ///< at most 1
};
/// So that all entries fit into width x height: two columns where those do at full size, else what leaves the letters largest. In a window
/// too small for any letters the rest is cut off.
HelpLayout fit_help(float width, float height, int entries, float column_width, float row_height);

}  // namespace mien::player
