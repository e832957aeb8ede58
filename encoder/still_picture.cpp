#include "encoder/still_picture.hpp"

#include <algorithm>
#include <cassert>

#include "core/texel_map.hpp"

namespace mien::encoder {
namespace {

constexpr std::int64_t kMostFrames = 100;

constexpr std::uint32_t bit(Surface s) { return 1u << int(s); }

/// Texels of the mouth's inside, and what lies around them and belongs to no chart: a filter reaches there.
std::vector<std::size_t> inside_mouth(const Mesh& neutral, int width, int height) {
    const TexelMap all = make_texel_map(neutral, width, height),
                   mouth = make_texel_map(neutral, width, height, bit(Surface::teeth) | bit(Surface::mouth));
    const int reach = std::max(1, width / 128);
    std::vector<std::size_t> found;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            bool near = mouth.used(x, y);
            for (int j = std::max(y - reach, 0); !near && !all.used(x, y) && j <= std::min(y + reach, height - 1); ++j)
                for (int i = std::max(x - reach, 0); !near && i <= std::min(x + reach, width - 1); ++i) near = mouth.used(i, j);
            if (near) found.push_back(std::size_t(y) * std::size_t(width) + std::size_t(x));
        }
    return found;
}

/// BT.601 luma in 1/256 steps.
int luma(const std::uint8_t* rgb) { return 77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2]; }

}  // namespace

Result<Image> still_picture(const Clip& clip, const Progress& progress) {
    assert(clip.texture && clip.neutral && clip.neutral->has_texcoords());
    MIEN_TRY(picture, clip.texture->read(0));
    const std::vector<std::size_t> texels = inside_mouth(*clip.neutral, picture.width, picture.height);
    if (texels.empty() || picture.channels != 3) return std::move(picture);
    const std::int64_t frames = clip.texture->frames(), step = (frames + kMostFrames - 1) / kMostFrames;
    for (std::int64_t frame = step; frame < frames; frame += step) {
        MIEN_TRY(seen, clip.texture->read(frame));
        for (const std::size_t i : texels) {
            const std::uint8_t* from = seen.pixels.data() + 3 * i;
            std::uint8_t* to = picture.pixels.data() + 3 * i;
            if (luma(from) > luma(to)) std::copy_n(from, 3, to);
        }
        if (progress) progress("looking into the mouth", frame, frames);
    }
    return std::move(picture);
}

}  // namespace mien::encoder
