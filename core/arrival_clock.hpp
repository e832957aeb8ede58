#pragma once

#include <deque>
#include <optional>

namespace mien {

/// When what a stream brings would come if nothing were ever late: of the last seconds the quickest arrival counts. Clocks that drift, and streams that go on
/// after a break, are followed. Times are seconds; `now` is any steady time that the caller brings.
class ArrivalClock {
public:
    static constexpr double kWindow = 2;     ///< seconds that the quickest is looked for in

    void restart() { window_.clear(); }      ///< media time counts anew
    /// What is of `media` has come.
    void arrived(double media, double now) {
        const Arrival arrival{now, now - media};
        while (!window_.empty() && window_.back().offset >= arrival.offset) window_.pop_back();
        window_.push_back(arrival);
        while (window_.front().at < now - kWindow) window_.pop_front();
    }
    /// When the moment 0 of the media came, or would have; none before anything has come.
    std::optional<double> zero() const { return window_.empty() ? std::nullopt : std::optional(window_.front().offset); }

private:
    struct Arrival {
        double at = 0, offset = 0;           // offset: `at` less the media time
    };
    std::deque<Arrival> window_;             // ascending in time and offset: the first is the quickest
};

}  // namespace mien
