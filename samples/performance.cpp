#include "samples/performance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mien::samples {
namespace {

Instant mix(const Instant& a, const Instant& b, float part) {
    Instant m;
    for (std::size_t i = 0; i < m.weights.size(); ++i) m.weights[i] = a.weights[i] + part * (b.weights[i] - a.weights[i]);
    m.head = {a.head.rotation.slerp(part, b.head.rotation), a.head.translation + part * (b.head.translation - a.head.translation)};
    for (int side : {0, 1}) {
        m.gaze.yaw[side] = a.gaze.yaw[side] + part * (b.gaze.yaw[side] - a.gaze.yaw[side]);
        m.gaze.pitch[side] = a.gaze.pitch[side] + part * (b.gaze.pitch[side] - a.gaze.pitch[side]);
    }
    return m;
}

}  // namespace

std::int64_t frames_in(double seconds, Rational frame_rate) {
    return std::max<std::int64_t>(1, std::llround(seconds * frame_rate.value()));
}

Result<Performance> cut(Performance performance, FrameRange range) {
    if (range.first < 0 || range.first >= range.end || range.end > performance.frames())
        return Error{ErrorCode::invalid, fmt::format("frames {}:{} are not in the performance, which has frames 0:{}", range.first, range.end, performance.frames())};
    performance.instants = {performance.instants.begin() + std::ptrdiff_t(range.first), performance.instants.begin() + std::ptrdiff_t(range.end)};
    if (!performance.sound) return performance;
    Sound& sound = *performance.sound;
    const auto place = [&](std::int64_t frame) {
        return std::ptrdiff_t(std::min(sound.length(), rescale(frame, performance.frame_rate.inverse(), make_rational(1, sound.sample_rate))) * sound.channels);
    };
    sound.samples = {sound.samples.begin() + place(range.first), sound.samples.begin() + place(range.end)};
    return performance;
}

Performance fit_length(Performance performance, double seconds) {
    const std::int64_t have = performance.frames(), want = frames_in(seconds, performance.frame_rate);
    assert(have > 0);
    const std::vector<Instant> once = performance.instants;
    performance.instants.resize(std::size_t(want));
    const std::int64_t blend = std::min(have / 2, frames_in(0.25, performance.frame_rate));
    for (std::int64_t f = have; f < want; ++f) {
        const std::int64_t k = f % have;
        const Instant& instant = once[std::size_t(k)];
        performance.instants[std::size_t(f)] =
            k < blend ? mix(once.back(), instant, float(k + 1) / float(blend + 1)) : instant;
    }
    if (performance.sound) {
        Sound& sound = *performance.sound;
        // The sound repeats with the picture: frame n * have begins sample round(n * have / rate) again.
        const Rational per_second = performance.frame_rate.inverse(), per_sample = make_rational(1, sound.sample_rate);
        const std::vector<float> original = sound.samples;
        const std::int64_t length = sound.length();
        sound.samples.assign(std::size_t(rescale(want, per_second, per_sample) * sound.channels), 0);
        for (std::int64_t first = 0; first < want; first += have) {
            const std::int64_t start = rescale(first, per_second, per_sample);
            const std::int64_t end = rescale(std::min(want, first + have), per_second, per_sample);
            const std::int64_t count = std::min(length, end - start) * sound.channels;
            std::copy_n(original.begin(), count, sound.samples.begin() + start * sound.channels);
        }
    }
    return performance;
}

Performance resample(const Performance& performance, Rational frame_rate) {
    if (frame_rate == performance.frame_rate) return performance;
    Performance other{frame_rate, {}, performance.sound};
    const std::int64_t last = performance.frames() - 1;
    const auto count = frames_in(performance.seconds(), frame_rate);
    for (std::int64_t f = 0; f < count; ++f) {
        const double at = std::min(double(last), double(f) / frame_rate.value() * performance.frame_rate.value());
        const auto k = std::min(std::int64_t(at), std::max<std::int64_t>(0, last - 1));
        other.instants.push_back(mix(performance.instants[std::size_t(k)],
                                     performance.instants[std::size_t(std::min(k + 1, last))], float(at - double(k))));
    }
    return other;
}

}  // namespace mien::samples
