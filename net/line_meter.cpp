#include "net/line_meter.hpp"

#include <algorithm>

namespace mien::net {

void LineMeter::arrived(double now, std::uint64_t bytes) {
    while (!spans_.empty() && spans_.front().begun < now - kWindow) spans_.pop_front();
    const std::optional<double> before = last_;
    last_ = now;
    if (!before || now - *before > kGap) return;   // the first of a burst may have been under way for any time
    if (spans_.empty() || now - spans_.back().begun > kSpan) spans_.push_back({now, 0, 0});
    spans_.back().busy += now - *before;
    spans_.back().bytes += bytes;
}

std::optional<double> LineMeter::bits_per_second(double now) const {
    std::uint64_t bytes = 0;
    double busy = 0;
    // The newest first: a line that has become slow must not be praised for what it took in no time before.
    for (auto span = spans_.rbegin(); span != spans_.rend() && span->begun >= now - kWindow && busy < kBusy; ++span) {
        bytes += span->bytes;
        busy += span->busy;
    }
    if (bytes < kLeast) return std::nullopt;
    return 8 * double(bytes) / std::max(busy, 1e-6);
}

}  // namespace mien::net
