#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/image.hpp"

namespace mien::player {

/// Sound of the performance through OpenAL, on a thread of its own. All methods may be called from any thread.
class SoundOutput {
public:
    /// Null when this machine has no sound device; the player then keeps time by itself. `why` is told.
    static std::unique_ptr<SoundOutput> open(int sample_rate, std::string* why = nullptr);
    ~SoundOutput();

    /// Sound from `first_sample` on (samples since the start of the performance); ascending. Gaps become silence.
    void push(std::int64_t first_sample, Sound sound);
    void flush(double media);              ///< drops everything; the next sound heard is that of `media` seconds
    /// So many seconds must wait before it begins, and begins again after it ran dry: what comes live comes unevenly.
    void set_prebuffer(double seconds);
    void play();
    void pause();
    void set_rate(double rate);            ///< pitch changes with it
    void set_muted(bool muted);
    void set_volume(double volume);        ///< 0 .. 1

    /// The time of the sample that leaves the loudspeaker now, seconds; none while nothing sounds.
    std::optional<double> heard() const;
    double buffered() const;               ///< seconds pushed and not yet given to the device

private:
    struct State;
    explicit SoundOutput(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::player
