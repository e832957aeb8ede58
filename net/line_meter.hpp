#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace mien::net {

/// How fast a line is, from when its bytes came. While the sender has more to send, bytes follow each other closely and their rate is the
/// line's; a longer gap is the sender's own, and says nothing. `now` is any steady time in seconds that the caller brings.
class LineMeter {
public:
    static constexpr double kGap = 0.25;       ///< seconds without a byte from which nothing was to be sent
    static constexpr double kWindow = 3;       ///< seconds: what is older is forgotten
    static constexpr double kBusy = 0.75;      ///< seconds of bytes following each other that are enough; older ones then count no more
    static constexpr std::uint64_t kLeast = 8u << 10;   ///< bytes from which a rate is told

    void arrived(double now, std::uint64_t bytes);
    /// The next gap was the reader's doing.
    void interrupted() { last_.reset(); }
    /// None while too little has come in bursts.
    std::optional<double> bits_per_second(double now) const;

private:
    struct Span {
        double begun = 0, busy = 0;            // busy: seconds in which bytes followed each other
        std::uint64_t bytes = 0;
    };
    static constexpr double kSpan = 0.1;       // arrivals are kept together for this long
    std::deque<Span> spans_;
    std::optional<double> last_;
};

}  // namespace mien::net
