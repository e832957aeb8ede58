#include "player/live_clock.hpp"

#include <cmath>

namespace mien::player {

void LiveClock::restart() {
    clock_.restart();
    wait_ = 0;
}

std::int64_t LiveClock::due(double now) const {
    const auto zero = clock_.zero();
    if (!zero) return -1;
    return std::int64_t(std::floor((now - *zero - std::max(delay_, wait_)) * frame_rate_ + 1e-6));
}

void LiveClock::follow_sound(double media, double now) {
    constexpr double kPace = 0.05;           // of the difference at each call: devices tell their time in steps
    const auto zero = clock_.zero();
    if (!zero || delay_ == 0) return;
    const double wanted = std::clamp(now - *zero - media, 0.0, kLongestWait);
    wait_ = wait_ == 0 ? wanted : wait_ + kPace * (wanted - wait_);
}

}  // namespace mien::player
