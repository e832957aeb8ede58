#include "player/live_clock.hpp"

#include <cmath>

namespace mien::player {

void LiveClock::arrived(std::int64_t frame, double now) {
    const Arrival arrival{now, now - double(frame) / frame_rate_};
    while (!window_.empty() && window_.back().offset >= arrival.offset) window_.pop_back();
    window_.push_back(arrival);
    while (window_.front().at < now - kWindow) window_.pop_front();
}

std::int64_t LiveClock::due(double now) const {
    if (window_.empty()) return -1;
    return std::int64_t(std::floor((now - window_.front().offset - delay_) * frame_rate_ + 1e-6));
}

}  // namespace mien::player
