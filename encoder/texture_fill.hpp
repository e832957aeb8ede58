#pragma once

#include <cstdint>
#include <vector>

#include "core/clip.hpp"

namespace mien::encoder {

/// Which texels of a width x height texture show the face, 1 or 0, rows from the top: where clip.mask is
/// above zero (nearest texel, when its size differs), else where the neutral mesh's texture triangles cover
/// the texel's centre. All ones when there is neither. A texel that a chart only touches is not used: what it
/// holds is mixed with the background.
std::vector<std::uint8_t> used_texels(const Clip& clip, int width, int height);

/// Fills unused texels from the used ones around them, smoother with distance: push-pull (Gortler et al.
/// 1996, "The Lumigraph", section 3.4). Which cells of the pyramid are needed is worked out once, so a frame
/// costs only the gaps and a thin seam around them. Integer-only: the same bytes on every machine.
class TextureFill {
public:
    /// used: width * height of 0 or not 0.
    TextureFill(int width, int height, const std::vector<std::uint8_t>& used);

    /// Nothing to do: every texel is used, or none is.
    bool empty() const { return levels_.empty(); }
    /// Overwrites the unused texels of `picture` (RGB, width x height).
    void apply(Image& picture);

private:
    struct Pull {
        std::uint32_t cell;  ///< its value is the mean of those children
        std::uint32_t children[4];
        std::uint32_t count;  ///< of children
    };
    struct Level {
        int width = 0, height = 0;
        std::vector<Pull> pulls;  ///< covered cells that someone needs
        std::vector<std::uint32_t>
            pushes;                      ///< uncovered cells that someone needs: from the next coarser level
        std::vector<std::uint16_t> rgb;  ///< of this frame, 1/64 steps; empty for level 0
    };
    std::vector<Level> levels_;  ///< 0: the picture itself
};

}  // namespace mien::encoder
