#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "coding/integer_model.hpp"
#include "coding/motion_basis.hpp"
#include "coding/side_gain.hpp"

namespace mien::coding {

/// Codes the vectors of a basis one after another: coarse points first, every value as
/// its difference from the weighted mean of the points it refers to and from what the other side of the face has shown. Writer, reader and the encoder's quantiser all run this one walk.
class VectorCoder {
public:
    VectorCoder(const MotionShape& shape, const PointOrder& order,
                const std::array<std::uint8_t, PointOrder::kLevels>& level_steps)
        : shape_(&shape), order_(&order), steps_(level_steps), model_(kContexts, kMixers, 3, 250),
          history_(std::size_t(shape.dimension()), 0), residual_(std::size_t(shape.dimension()), 0),
          surprise_(std::size_t(shape.dimension()), 0) {}

    /// What is known of a value before it is coded.
    struct Value {
        std::size_t index;         ///< in the vector
        std::size_t position;      ///< of its point in the order
        std::int64_t base;         ///< weighted mean of the references
        std::int64_t prediction;   ///< with what the other side of the face says
        std::int32_t step;
        double handed_on;          ///< share of its surprise that the next value expects, as its mirror; for weighing errors
    };
    /// decide(value, contexts, model) -> residual; called for every value, must return what is
    /// coded. For a decoder its result is ignored. Stops early when the coder failed.
    template <class Coder, class Decide>
    void code(Coder& coder, std::vector<std::int32_t>& vector, Decide&& decide) {
        const int coordinates = int(shape_->coordinates);
        for (std::size_t at = 0; at < order_->order.size(); ++at) {
            const std::size_t point = order_->order[at];
            const int level = order_->level[at];
            const std::int32_t step = steps_[std::size_t(level)];
            const auto references = order_->of(at);
            const std::size_t partner = order_->partner[at];
            const bool followed = at + 1 < order_->order.size() && order_->partner[at + 1] == point && order_->order[at + 1] != point;
            std::array<std::uint32_t, 3> here{};
            for (int c = 0; c < coordinates; ++c) {
                const std::size_t i = point * std::size_t(coordinates) + std::size_t(c);
                std::int64_t sum = 0, weight = 0, low = 0, high = 0, around = 0;
                for (const auto& reference : references) {
                    const std::size_t j = std::size_t(reference.point) * std::size_t(coordinates) + std::size_t(c);
                    const std::int64_t value = vector[j];
                    low = weight ? std::min(low, value) : value;
                    high = weight ? std::max(high, value) : value;
                    sum += value * reference.weight;
                    around += std::abs(std::int64_t(residual_[j])) * reference.weight;
                    weight += reference.weight;
                }
                std::int64_t base = 0, size = 0;
                if (weight) {
                    base = rounded(sum, weight);
                    size = around * 4 / weight;
                }
                // What was new at the other side is expected here too, as far as this vector has been symmetric so far.
                std::int64_t seen = 0, prediction = base;
                SideGain& gain = gain_[std::size_t(c)];
                if (partner != point) {
                    seen = surprise_[partner * std::size_t(coordinates) + std::size_t(c)];
                    if (c == 0 && coordinates == 3) seen = -seen;
                    prediction += seen * gain.value() >> 16;
                }
                const IntegerModel::Contexts contexts =
                    contexts_of(c, level, here, std::uint32_t(std::min<std::int64_t>(size, 1 << 20)),
                                std::uint32_t(std::min<std::int64_t>((high - low) * 2 / steps_[0], 1 << 20)), history_[i],
                                references.empty(), prediction);
                const double handed_on = followed ? double(gain.value()) / SideGain::kOne : 0.0;
                std::int32_t residual = decide(Value{i, at, base, prediction, step, handed_on}, contexts, model_);
                model_.code(coder, residual, contexts);
                const std::int64_t value = prediction + std::int64_t(residual) * step;
                if (Coder::kDecodes && (value > kMaxValue || value < -kMaxValue)) {
                    coder.fail();
                    return;
                }
                vector[i] = std::int32_t(value);
                residual_[i] = residual;
                surprise_[i] = value - base;
                if (partner != point) gain.learn(seen, surprise_[i]);
                here[std::size_t(c)] = std::uint32_t(std::abs(std::int64_t(residual)));
                const std::uint32_t grown = std::min(here[std::size_t(c)], 60u) * 16;
                history_[i] = std::uint16_t((history_[i] * 7u + grown * 3u + 4) / 8);
            }
            if (Coder::kDecodes && (at & 255) == 0 && coder.failed()) return;
        }
        ++vector_;
        for (SideGain& gain : gain_) gain = {};
    }

    /// Learns from vectors that both sides have already: they are walked as if coded.
    void learn(std::span<const std::vector<std::int32_t>> vectors) {
        SilentCoder silent;
        std::vector<std::int32_t> walk(std::size_t(shape_->dimension()), 0);
        for (const auto& vector : vectors)
            code(silent, walk, [&](const Value& v, const auto&, auto&) {
                return std::int32_t((std::int64_t(vector[v.index]) - v.prediction) / v.step);
            });
    }

    static constexpr std::int64_t kMaxValue = 1 << 28;

private:
    static constexpr int kMixers = PointOrder::kLevels;
    static constexpr std::array<int, 6> kContexts{8 * 48, 10 * 10 * 2, 5 * 5 * 5 * 3, 12 * 8 * 3, 10 * 12, 32 * 4};

    IntegerModel::Contexts contexts_of(int c, int level, const std::array<std::uint32_t, 3>& here, std::uint32_t around,
                                       std::uint32_t spread, std::uint32_t history, bool alone,
                                       std::int64_t prediction) const {
        const int near = magnitude_level(around, 10);
        const int wide = magnitude_level(spread, 10);
        const int past = magnitude_level(history / 2, 12);
        const int one = c > 0 ? magnitude_level(here[std::size_t(c - 1)], 4) + 1 : 0;
        const int two = c > 1 ? magnitude_level(here[std::size_t(c - 2)], 4) + 1 : 0;
        const std::uint32_t mixed = around + spread + history / 4 + 8 * (here[0] + here[1] + here[2]) / 2;
        IntegerModel::Contexts contexts;
        contexts.input[0] = level * 48 + std::min(vector_, 47);
        contexts.input[1] = (near * 10 + wide) * 2 + (alone ? 1 : 0);
        contexts.input[2] = ((one * 5 + two) * 5 + std::min(near / 2, 4)) * 3 + c;
        contexts.input[3] = (past * 8 + level) * 3 + c;
        contexts.input[4] = wide * 12 + past;
        contexts.input[5] = fine_level(mixed) * 4 + std::min(level, 3);
        contexts.mixer = level;
        contexts.sign = prediction > steps_[0] / 4 ? 2 : prediction < -steps_[0] / 4 ? 0 : 1;
        return contexts;
    }
    // sum / weight to the nearest integer, halves up, for any sign of sum.
    static std::int64_t rounded(std::int64_t sum, std::int64_t weight) {
        const std::int64_t twice = 2 * sum + weight;
        return twice >= 0 ? twice / (2 * weight) : -((-twice + 2 * weight - 1) / (2 * weight));
    }
    // Two steps per octave.
    static int fine_level(std::uint32_t m) {
        if (m < 2) return int(m);
        const int top = 31 - __builtin_clz(m);
        return std::min(31, 2 * top + int(m >> (top - 1) & 1));
    }

    const MotionShape* shape_;   // pointers, so that an encoder can copy a coder and try one way
    const PointOrder* order_;
    std::array<std::uint8_t, PointOrder::kLevels> steps_;
    IntegerModel model_;
    std::vector<std::uint16_t> history_;   ///< how large this value's residuals were in the vectors before
    std::vector<std::int32_t> residual_;
    std::vector<std::int64_t> surprise_;   ///< value less weighted mean of the references
    std::array<SideGain, 3> gain_{};
    int vector_ = 0;
};

}  // namespace mien::coding
