#pragma once

#include <optional>
#include <vector>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "samples/actor.hpp"
#include "samples/speech.hpp"

namespace mien::samples {

/// What an actor does over time, before it is known which actor.
struct Performance {
    Rational frame_rate{30, 1};     ///< frames per second; instants[f] is at f / frame_rate seconds
    std::vector<Instant> instants;
    std::optional<Sound> sound;

    std::int64_t frames() const { return std::int64_t(instants.size()); }
    double seconds() const { return double(frames()) / frame_rate.value(); }
};

/// Frames that last `seconds`: the nearest whole number, at least one.
std::int64_t frames_in(double seconds, Rational frame_rate);

/// An utterance spoken with mouth, eyes, brows and head. With `seconds` > 0 it lasts so long: what is too long is cut,
/// what is too short is said again as often as it fits, then listens in silence. Deterministic by seed.
Performance perform_speech(const Utterance& utterance, Rational frame_rate, double seconds, std::uint64_t seed);

/// Silent range of motion: every muscle group apart, then whole expressions, with blinks and small head motion.
/// `seconds` <= 0: once through (about 24 s).
Performance perform_expressions(Rational frame_rate, double seconds, std::uint64_t seed);

/// Frames first <= f < end.
struct FrameRange {
    std::int64_t first = 0, end = 0;
};
/// Only these frames, with the sound of their time. Error: invalid for a range outside the performance.
Result<Performance> cut(Performance performance, FrameRange range);

/// Makes a performance last `seconds`: cut, or repeated from its start over a blend of a quarter second.
Performance fit_length(Performance performance, double seconds);

/// The same motion at another frame rate: linear in weights and gaze, spherical in rotation. Sound is untouched.
Performance resample(const Performance& performance, Rational frame_rate);

}  // namespace mien::samples
