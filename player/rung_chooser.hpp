#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace mien::player {

/// Which rung of a ladder a line can keep up with: quickly down, slowly up. Knows no threads; `now` is any steady time in seconds that the caller brings.
///
/// Down as soon as less waits to be shown than half of what ever did and the line takes less than the rung needs, to the finest rung that fits; and to
/// the coarsest when nearly nothing is left, whatever the line was measured to take. Up one rung after the buffer has been nearly full for a while and
/// the line is known to take the next rung easily, or too little is sent to measure it. A rung that did not hold is tried again later each time.
class RungChooser {
public:
    static constexpr double kHold = 3;              ///< seconds of a full buffer before a finer rung is tried
    static constexpr double kLongestHold = 60;
    static constexpr double kTrial = 20;            ///< seconds in which a finer rung has to prove itself
    static constexpr double kFull = 0.8, kLow = 0.5, kEmpty = 0.2;   ///< of the most that ever waited
    static constexpr double kFits = 0.8, kEasily = 0.7;              ///< of the line: what a rung may need, on the way down and up

    /// bits_per_second: of the whole stream with each rung, the coarsest first, at least one; 0: not known.
    RungChooser(std::vector<double> bits_per_second, std::size_t first);

    struct Line {
        double buffer = 0;                          ///< seconds that have come and are still to be shown
        std::optional<double> bits_per_second;      ///< that it takes; none: not known
    };
    /// The rung from now on. `speed`: of playing. To be asked a few times a second.
    std::size_t choose(double now, const Line& line, double speed = 1);
    /// The buffer begins anew, as after a seek: that it is empty means nothing until it has filled.
    void refill() { filling_ = true, full_since_.reset(); }
    /// Somebody else has chosen: goes on from there.
    void set_rung(std::size_t rung) { rung_ = rung, full_since_.reset(), tried_.reset(); }

    std::size_t rung() const { return rung_; }

private:
    void down(double now, std::size_t rung);
    std::size_t fitting(double bits_per_second, double speed) const;

    std::vector<double> needs_;
    std::size_t rung_;
    double most_ = 0;                               // buffer, ever
    bool filling_ = true;
    std::vector<double> holds_;                     // seconds of a full buffer before this rung is tried
    std::optional<double> full_since_, tried_;      // tried_: when it last went up
};

}  // namespace mien::player
