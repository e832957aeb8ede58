#include "player/rung_chooser.hpp"

#include <algorithm>
#include <cassert>

namespace mien::player {

RungChooser::RungChooser(std::vector<double> bits_per_second, std::size_t first)
    : needs_(std::move(bits_per_second)), rung_(std::min(first, needs_.size() - 1)), holds_(needs_.size(), kHold) {
    assert(!needs_.empty());
}

std::size_t RungChooser::fitting(double bits_per_second, double speed) const {
    std::size_t rung = 0;
    for (std::size_t r = 0; r < needs_.size(); ++r)
        if (needs_[r] * speed <= bits_per_second) rung = r;
    return rung;
}

void RungChooser::down(double now, std::size_t rung) {
    if (rung >= rung_) return;
    if (tried_ && now - *tried_ < kTrial) holds_[rung_] = std::min(2 * holds_[rung_], kLongestHold);
    tried_.reset();
    full_since_.reset();
    rung_ = rung;
}

std::size_t RungChooser::choose(double now, const Line& line, double speed) {
    most_ = std::max(most_, line.buffer);
    if (line.buffer >= kLow * most_ && line.buffer > 0) filling_ = false;
    if (tried_ && now - *tried_ >= kTrial) {
        holds_[rung_] = kHold;
        tried_.reset();
    }
    const bool too_slow = line.bits_per_second && *line.bits_per_second < needs_[rung_] * speed;
    if (!filling_ && line.buffer < kEmpty * most_) {
        down(now, 0);
    } else if (too_slow && (filling_ || line.buffer < kLow * most_)) {
        down(now, fitting(kFits * *line.bits_per_second, speed));
    }
    if (line.buffer < kFull * most_ || line.buffer <= 0 || filling_) {
        full_since_.reset();
    } else if (!full_since_) {
        full_since_ = now;
    } else if (rung_ + 1 < needs_.size() && now - *full_since_ >= holds_[rung_ + 1] &&
               (!line.bits_per_second || needs_[rung_ + 1] * speed <= kEasily * *line.bits_per_second)) {
        ++rung_;
        tried_ = full_since_ = now;
    }
    return rung_;
}

}  // namespace mien::player
