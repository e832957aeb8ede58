#pragma once

#include <algorithm>
#include <cstdint>

#include "core/arrival_clock.hpp"

namespace mien::player {

/// Which frame of a live stream is due. Frames come unevenly; each is shown `delay` after the moment at which the quickest of the last seconds would have
/// brought it, so a delay above the network's jitter makes the beat even, and with none every frame is shown as it comes. `now` is any steady time in seconds
/// that the caller brings.
class LiveClock {
public:
    LiveClock(double frame_rate, double delay) : frame_rate_(frame_rate), delay_(delay) {}

    void restart();                          ///< frames count anew
    /// A frame has been decoded.
    void arrived(std::int64_t frame, double now) { clock_.arrived(double(frame) / frame_rate_, now); }
    /// The newest frame that may be shown; -1 before any has come.
    std::int64_t due(double now) const;

    /// The sound of `media` seconds is heard now: pictures that the delay would show before their sound wait for it, `kLongestWait` at most. With no delay
    /// asked for they do not.
    void follow_sound(double media, double now);
    static constexpr double kLongestWait = 0.3;

private:
    double frame_rate_, delay_;
    double wait_ = 0;                        // for the sound, if more than delay_
    ArrivalClock clock_;
};

}  // namespace mien::player
