#pragma once

#include "player/options.hpp"

namespace mien::player {

/// Plays in a window until it is closed. Returns the exit code. Throws EnvironmentError: no display, no OpenGL 4.5.
int run_window(const Options& options, double process_start);

}  // namespace mien::player
