#pragma once

#include "player/options.hpp"

namespace mien::player {

/// Plays without a window, as fast as it goes, into a PNG, an MP4, a contact sheet, or all of them in one pass.
/// `process_start`: steady_clock seconds. Returns the exit code, 1 also where something
/// that was asked for is damaged and the rest has been written; what went wrong is told on stderr. Throws EnvironmentError.
int run_headless(const Options& options, double process_start);

/// Seconds of the steady clock.
double steady_seconds();

}  // namespace mien::player
