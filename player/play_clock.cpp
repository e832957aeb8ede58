#include "player/play_clock.hpp"

#include <cmath>

namespace mien::player {

void PlayClock::run(double now) {
    if (running_) return;
    since_ = now;
    running_ = true;
}

void PlayClock::stop(double now) {
    media_ = at(now);
    running_ = false;
}

void PlayClock::set_rate(double now, double rate) {
    media_ = at(now);
    since_ = now;
    rate_ = rate;
}

void PlayClock::follow(double now, double heard) {
    if (!running_) return;
    const double late = heard - at(now);
    media_ += std::abs(late) > kJump ? late : kGentle * late;
}

}  // namespace mien::player
