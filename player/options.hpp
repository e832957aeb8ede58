#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/rational.hpp"
#include "core/result.hpp"
#include "player/stream_model.hpp"
#include "render/camera.hpp"

namespace mien::player {

/// What the command line asks for.
struct Options {
    std::string input;                                   ///< mien:// URL or a file
    bool headless = false;
    bool benchmark = false;                              ///< headless: draw everything, keep nothing, print figures
    std::filesystem::path output;                        ///< .png or .mp4
    std::filesystem::path sheet;                         ///< contact sheet PNG
    std::filesystem::path compare;                       ///< clip folder with the truth
    std::filesystem::path stats;                         ///< JSON
    bool overwrite = false;                              ///< output and sheet replace what is there
    render::View view = render::View::front;
    int width = 640, height = 720;
    double time = 0;                                     ///< seconds: start, or the moment of a PNG
    std::optional<std::int64_t> first_frame, end_frame;  ///< --frames A:B, B not included
    std::optional<Rational> frame_rate;                  ///< of the mp4; default: the stream's own
    std::optional<std::filesystem::path> cache;          ///< folder; none: no cache
    bool loop = false;
    bool paused = false, muted = false, full_screen = false;   ///< window: how it begins
    double speed = 1;
    double volume = 1;                                   ///< 0 .. 1
    bool list = false;
    bool sound = true;
    std::size_t motion_rung = 63;                        ///< highest rung of motion to ask for
    double delay = 0.05;                                 ///< seconds that frames of a live stream wait to be shown evenly
    std::optional<double> seconds;                       ///< headless: how much of a live stream
    TextureChoice texture;
    std::optional<double> model_kb;                      ///< of the face model before playing begins, 1000 bytes; none: all without a window, else what it cannot do without
    double wait = 20;                                    ///< seconds to wait for the stream to be ready
    int attempts = 4;                                    ///< connections tried before the first has worked; -1: as many as the wait allows
};

/// Before anything is opened: see io::guard_outputs.
Result<void> check_outputs(const Options& options);

/// A moment as people write it: 90, 1:30, 0:01:30.5; seconds.
Result<double> parse_time(std::string_view text);

}  // namespace mien::player
