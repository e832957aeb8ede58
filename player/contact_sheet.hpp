#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image.hpp"
#include "core/rational.hpp"
#include "render/camera.hpp"

namespace mien::player {

/// Eight moments of a performance from three sides, as one picture: a column a moment, a row a viewpoint.
class ContactSheet {
public:
    static constexpr int kMoments = 8;
    static constexpr std::array kViews = {render::View::left, render::View::front, render::View::right};

    /// frames: of the performance; tiles of tile_width x tile_height pixels.
    ContactSheet(std::int64_t first_frame, std::int64_t end_frame, int tile_width, int tile_height);

    /// The frames shown, ascending: the middles of eight equal parts.
    const std::vector<std::int64_t>& moments() const { return moments_; }
    void place(int moment, int view, const Image& tile);
    /// With each moment's time in its head row.
    Image finish(Rational frame_rate) const;

private:
    std::vector<std::int64_t> moments_;
    int tile_width_, tile_height_;
    Image sheet_;
};

}  // namespace mien::player
