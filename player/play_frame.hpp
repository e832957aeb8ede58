#pragma once

#include <optional>

#include "decoder/av_texture.hpp"
#include "model/linear_motion.hpp"

namespace mien::player {

/// One instant ready to be drawn: the motion and the texture of one and the same frame.
struct PlayFrame {
    std::int64_t frame = 0;
    model::Motion motion;
    std::optional<decoder::TextureFrame> texture = {};   ///< none when the stream has no texture track
    std::size_t texture_rung = 0;
    double decoded_at = 0;                          ///< steady seconds; of a live stream
};

}  // namespace mien::player
