#include "bench/picture_row.hpp"

#include <algorithm>

#include "bench/texture_codec.hpp"
#include "render/still.hpp"

namespace mien::bench {
namespace {

constexpr int kWidth = 320, kHeight = 380;        // of a whole head
constexpr int kPartLeft = 80, kPartTop = 115, kPartWidth = 160, kPartHeight = 170;  // of it that is shown twice as large

void paste(Image& row, const Image& tile, int left, int top) {
    for (int y = 0; y < tile.height; ++y) std::copy_n(tile.at(0, y), tile.width * 3, row.at(left, top + y));
}

Image part_of(const Image& picture, int left, int top, int width, int height) {
    Image part(width, height, 3);
    for (int y = 0; y < height; ++y) std::copy_n(picture.at(left, top + y), width * 3, part.at(0, y));
    return part;
}

}  // namespace

Result<Image> picture_row(const Clip& clip, const std::vector<std::string>& codecs, double kbps, std::int64_t frame,
                          const Progress& progress) {
    if (!clip.neutral || !clip.neutral->has_texcoords() || !clip.vertices || !clip.texture || clip.texture->frames() <= frame ||
        clip.vertices->frames <= frame)
        return Error{ErrorCode::missing, "a row of pictures needs a clip with a textured mesh, vertices and a texture video of more than " +
                                             std::to_string(frame) + " frames"};
    render::StillRenderer still(*clip.neutral);
    still.set_positions(clip.vertices->frame(frame));
    const auto camera =
        render::frame_box(render::bounding_box(clip.neutral->positions), float(kWidth) / kHeight, render::View::front).camera();
    Image row(kWidth * int(codecs.size() + 1), kHeight + 2 * kPartHeight, 3);
    const auto add = [&](const Image& texture, int column) {
        still.set_texture(texture);
        paste(row, still.picture(camera, kWidth, kHeight), column * kWidth, 0);
        const Image large = still.picture(camera, 2 * kWidth, 2 * kHeight);
        paste(row, part_of(large, 2 * kPartLeft, 2 * kPartTop, 2 * kPartWidth, 2 * kPartHeight), column * kWidth, kHeight);
    };
    MIEN_TRY(truth, clip.texture->read(frame));
    add(truth, 0);
    for (std::size_t c = 0; c < codecs.size(); ++c) {
        MIEN_TRY(coded, encode_ours(clip, codecs[c], kbps, progress));
        Image received;
        MIEN_CHECK(decode_texture(coded, [&](std::int64_t number, const Image& picture) -> Result<void> {
            if (number == frame) received = picture;
            return {};
        }));
        add(received, int(c) + 1);
    }
    return row;
}

}  // namespace mien::bench
