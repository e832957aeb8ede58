#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

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

/// What the numbers of one causal frame would cost, each worked out once: paths of other states and slopes ask for the same.
class FrameCosts {
public:
    explicit FrameCosts(const coding::MotionFrames& frames) : frames_(frames), known_(std::size_t(frames.layout().total())) {}

    double bits(int channel, const coding::IntegerModel::Contexts& contexts, std::int32_t number) {
        auto& known = known_[std::size_t(channel)];
        for (const Known& k : known)
            if (k.number == number && k.contexts == contexts) return k.bits;
        known.push_back({contexts, number, frames_.model().cost(number, contexts)});
        return known.back().bits;
    }

    const coding::MotionFrames& frames() const { return frames_; }

private:
    struct Known {
        coding::IntegerModel::Contexts contexts;
        std::int32_t number;
        double bits;
    };
    const coding::MotionFrames& frames_;
    std::vector<std::vector<Known>> known_;   // per channel; short
};

/// The numbers of one causal frame, an object of its own.
struct FramePath {
    std::vector<std::int32_t> numbers;   ///< per channel
    std::vector<double> decoded;         ///< per channel, in steps
    double squared_error = 0;            ///< squared steps
};

/// The path through the quantisers' trellis with the least squared error + lambda * bits (Viterbi; the model as it is before the frame).
/// target(channel): in steps; settled(channel): the number it must have, if any. channels: the first so many.
template <class Target, class Settled>
FramePath choose_path(FrameCosts& costs, int channels, double lambda, const Target& target, const Settled& settled) {
    using Trellis = coding::QuantiserTrellis;
    const coding::MotionFrames& frames = costs.frames();
    constexpr double kMost = double(1 << 25);
    // Of two values nearly as far off the smaller one is cheaper.
    constexpr double kTie = 0.05;
    struct Node {
        double cost = 1e300;
        std::int32_t near = 0, far = 0;
    };
    struct Step {
        std::int32_t number = 0;
        int from = 0;
    };
    std::array<Node, Trellis::kStates> now, next;
    std::vector<std::array<Step, Trellis::kStates>> steps(static_cast<std::size_t>(channels));
    std::vector<double> predicted(static_cast<std::size_t>(channels));
    now[0].cost = 0;
    for (int c = 0; c < channels; ++c) {
        predicted[std::size_t(c)] = double(frames.predict(c)) / coding::MotionBasis::kFraction;
        const double wanted = target(c) - predicted[std::size_t(c)];
        const double size = std::min(std::abs(wanted), kMost);
        const std::int32_t sign = wanted < 0 ? -1 : 1;
        const std::optional<std::int32_t> given = settled(c);
        next.fill({});
        for (int state = 0; state < Trellis::kStates; ++state) {
            const Node& node = now[std::size_t(state)];
            if (node.cost == 1e300) continue;
            const bool shifted = Trellis::shifted(state);
            const auto contexts = frames.frame_contexts(c, 0, {node.near, node.far, c > 0 ? frames.last_size(c - 1) : 0}, shifted);
            const auto attempt = [&](std::int32_t number) {
                const double error = wanted - double(Trellis::halves(state, number)) / 2;
                const double bits = given ? 0.0 : costs.bits(c, contexts, number);
                const double cost = node.cost + error * error + lambda * bits;
                const std::size_t to = std::size_t(Trellis::next(state, number));
                if (cost >= next[to].cost) return;
                next[to] = {cost, number, node.near};
                steps[std::size_t(c)][to] = {number, state};
            };
            if (given) {
                attempt(*given);
                continue;
            }
            const std::int32_t low = std::max(0, std::int32_t(std::floor(size + (shifted ? 0.5 : 0.0) - kTie)));
            attempt(sign * low);
            attempt(sign * (low + 1));
            if (low == 1 || low == 2) attempt(0);
        }
        now = next;
    }
    FramePath path;
    path.numbers.resize(static_cast<std::size_t>(channels));
    path.decoded.resize(static_cast<std::size_t>(channels));
    int state = 0;
    for (int s = 1; s < Trellis::kStates; ++s)
        if (now[std::size_t(s)].cost < now[std::size_t(state)].cost) state = s;
    for (int c = channels; c-- > 0;) {
        const Step& step = steps[std::size_t(c)][std::size_t(state)];
        path.numbers[std::size_t(c)] = step.number;
        path.decoded[std::size_t(c)] = predicted[std::size_t(c)] + double(Trellis::halves(step.from, step.number)) / 2;
        const double error = target(c) - path.decoded[std::size_t(c)];
        path.squared_error += error * error;
        state = step.from;
    }
    return path;
}

/// A causal packet ends on a whole byte: of the paths of a few slopes around `lambda` the one whose packet costs least, as it will be
/// stored. begun: what stands before the frame in the packet.
template <class Target, class Settled>
FramePath choose_packet(coding::MotionFrames& frames, const Metered& begun, double lambda, const Target& target, const Settled& settled) {
    FrameCosts costs(frames);
    FramePath best;
    double least = 1e300;
    for (const double scale : {1.0, 0.7, 1.4, 0.5, 2.0}) {
        FramePath path = choose_path(costs, frames.layout().total(), lambda * scale, target, settled);
        if (path.numbers == best.numbers) continue;
        Metered coder = begun;
        frames.try_frame();
        frames.code_frame(coder, [&](int c) { return path.numbers[std::size_t(c)]; });
        frames.take_back_frame();
        const double total = path.squared_error + lambda * 8 * double(coder.finish().size());
        if (total < least) least = total, best = std::move(path);
    }
    return best;
}

}  // namespace mien::encoder
