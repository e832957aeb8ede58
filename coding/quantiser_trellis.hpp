#pragma once

#include <cstdint>

namespace mien::coding {

/// Dependent quantisation: of two quantisers with the same step, one shifted by half of it away from zero, the numbers coded before say
/// which is next. Their values together lie half a step apart, and a path through the trellis of states finds good ones among them (as in
/// H.266; Fischer, Wang 1992, "Entropy-constrained trellis-coded quantization"). A run begins in state 0.
struct QuantiserTrellis {
    static constexpr int kStates = 8;

    /// Values: 0, +-1/2, +-3/2, ... steps instead of 0, +-1, +-2, ...
    static constexpr bool shifted(int state) { return state & 1; }
    /// After the number `index`.
    static constexpr int next(int state, std::int32_t index) { return kNext[state][index & 1]; }
    /// What `index` stands for, in half steps.
    static constexpr std::int64_t halves(int state, std::int32_t index) {
        return 2 * std::int64_t(index) - (shifted(state) ? (index > 0) - (index < 0) : 0);
    }

private:
    static constexpr std::uint8_t kNext[kStates][2] = {{0, 2}, {5, 7}, {1, 3}, {6, 4}, {2, 0}, {4, 6}, {3, 1}, {7, 5}};
};

}  // namespace mien::coding
