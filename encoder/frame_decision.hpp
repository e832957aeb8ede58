#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

#include "coding/motion_frames.hpp"

/// What to code where less would do: the decisions that every encoder of motion frames shares.
namespace mien::encoder {

/// A range encoder that adds up what each channel costs.
class Metered {
public:
    static constexpr bool kDecodes = false;
    void code(int& bit, coding::Probability set) {
        encoder_.code(bit, set);
        bits_ += coding::code_length(bit, set);
    }
    bool failed() const { return false; }
    void fail() { assert(false); }
    double take_bits() { return std::exchange(bits_, 0.0); }
    std::uint64_t digest() const { return encoder_.digest(); }
    Bytes finish() { return encoder_.finish(); }

private:
    coding::RangeEncoder encoder_;
    double bits_ = 0;
};

/// The integer near `wanted` that is worth its bits. lambda: squared steps per bit; cost(v): bits.
template <class Cost>
std::int32_t decide(double wanted, double lambda, const Cost& cost) {
    constexpr double most = double(1 << 25);
    const std::int32_t nearest = std::int32_t(std::lround(std::clamp(wanted, -most, most)));
    if (nearest == 0 || lambda <= 0) return nearest;
    const int towards_zero = nearest > 0 ? -1 : 1;
    std::array<std::int32_t, 3> tried{nearest, nearest + towards_zero, 0};
    std::int32_t best = nearest;
    double best_cost = 1e300;
    for (std::size_t i = 0; i < (std::abs(nearest) <= 2 ? 3u : 2u); ++i) {
        if (i == 2 && tried[1] == 0) break;
        const double error = wanted - tried[i];
        const double total = error * error + lambda * cost(tried[i]);
        if (total < best_cost) best_cost = total, best = tried[i];
    }
    return best;
}

/// A causal packet ends on a whole byte: of a few decision slopes around `lambda` the one whose packet costs least, as it will be
/// stored. begun: what stands before the frame in the packet. target(channel): in steps; settled(channel): the number it must have, if any.
template <class Target, class Settled>
double packet_slope(coding::MotionFrames& frames, const Metered& begun, double lambda, const Target& target, const Settled& settled) {
    const coding::MotionFrames::FrameState before = frames.frame_state();
    double best = 1e300, chosen = lambda;
    for (const double scale : {1.0, 0.7, 1.4, 0.5, 2.0}) {
        Metered coder = begun;
        double error = 0;
        frames.code_frame(coder, [&](int c, std::int64_t prediction, const coding::IntegerModel::Contexts& contexts, const coding::IntegerModel& model) {
            const double wanted = target(c) - double(prediction) / coding::MotionBasis::kFraction;
            const std::optional<std::int32_t> given = settled(c);
            const std::int32_t v = given ? *given : decide(wanted, lambda * scale, [&](std::int32_t q) { return model.cost(q, contexts); });
            error += (wanted - v) * (wanted - v);
            return v;
        });
        frames.restore(before);
        const double total = error + lambda * 8 * double(coder.finish().size());
        if (total < best) best = total, chosen = lambda * scale;
    }
    return chosen;
}

}  // namespace mien::encoder
