#include "player/contact_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "player/label.hpp"

namespace mien::player {
namespace {

constexpr int kHead = 22;   // pixels above the tiles, for the times

}  // namespace

ContactSheet::ContactSheet(std::int64_t first_frame, std::int64_t end_frame, int tile_width, int tile_height)
    : tile_width_(tile_width), tile_height_(tile_height),
      sheet_(tile_width * kMoments, kHead + tile_height * int(kViews.size()), 3) {
    std::fill(sheet_.pixels.begin(), sheet_.pixels.end(), std::uint8_t(24));
    const std::int64_t frames = std::max<std::int64_t>(1, end_frame - first_frame);
    for (int i = 0; i < kMoments; ++i) moments_.push_back(first_frame + (2 * i + 1) * frames / (2 * kMoments));
}

void ContactSheet::place(int moment, int view, const Image& tile) {
    paste(sheet_, tile, moment * tile_width_, kHead + view * tile_height_);
}

Image ContactSheet::finish(Rational frame_rate) const {
    Image sheet = sheet_;
    for (int i = 0; i < kMoments; ++i)
        draw_label(sheet, i * tile_width_ + 8, 6, 1, fmt::format("{:.2f} s", double(moments_[std::size_t(i)]) / frame_rate.value()));
    return sheet;
}

}  // namespace mien::player
