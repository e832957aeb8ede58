#pragma once

#include <cstdint>
#include <deque>

namespace mien::player {

/// Which frame of a live stream is due. Frames come unevenly; each is shown `delay` after the moment at which the quickest of the last seconds would have
/// brought it, so a delay above the network's jitter makes the beat even, and with none every frame is shown as it comes. Clocks that drift and streams
/// that go on after a break are followed. `now` is any steady time in seconds that the caller brings.
class LiveClock {
public:
    static constexpr double kWindow = 2;     ///< seconds that the quickest is looked for in

    LiveClock(double frame_rate, double delay) : frame_rate_(frame_rate), delay_(delay) {}

    void restart() { window_.clear(); }      ///< frames count anew
    /// A frame has been decoded.
    void arrived(std::int64_t frame, double now);
    /// The newest frame that may be shown; -1 before any has come.
    std::int64_t due(double now) const;

private:
    struct Arrival {
        double at = 0, offset = 0;           ///< offset: `at` less the frame's own time
    };
    double frame_rate_, delay_;
    std::deque<Arrival> window_;             ///< ascending in time and offset: the first is the quickest
};

}  // namespace mien::player
