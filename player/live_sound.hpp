#pragma once

#include <optional>

#include "decoder/av_sound.hpp"
#include "player/sound_output.hpp"

namespace mien::player {

/// Keeps the sound of a live stream flowing: as close behind its sender as it came at first, though the clocks of sender and device differ, and from its newest
/// after a break.
class LiveSound {
public:
    static constexpr double kPrebuffer = 0.04;   ///< seconds that wait before it begins

    explicit LiveSound(SoundOutput& output);
    /// `now`: steady seconds at which it came.
    void add(decoder::SoundDecoder::Block block, double now);

private:
    void begin(double media, double offset);
    void pace(double level);

    SoundOutput& output_;
    std::optional<std::int64_t> end_;            // sample after the last one
    double offset_ = 0;                          // from the media's time to when it came, where it began
    std::optional<double> level_, wanted_;       // seconds from what is heard to what came last: smoothed, and as it was at first
    int settled_ = 0;                            // blocks since it began
    double rate_ = 1;
};

}  // namespace mien::player
