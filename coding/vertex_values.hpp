#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "coding/integer_model.hpp"
#include "coding/mesh_traversal.hpp"
#include "coding/side_gain.hpp"

namespace mien::coding {

inline constexpr std::int32_t kMaxVertexValue = 1 << 24;

/// Contexts of code_values; keep one over several sets of values of a kind and the later ones start warm.
template <int kChannels>
struct VertexValueModel {
    static constexpr int kLevels = 20;
    static constexpr int kLimit = 255;
    IntegerModel model{std::vector<int>{kChannels * 8, kChannels * kLevels * 2, kLevels * kLevels, kLevels * 8}, 1, kChannels, kLimit};
};

/// Codes kChannels integers a vertex in traversal order, each as the difference from its prediction over the mesh, and, where
/// its mirror (Mesh::mirror, empty: none) and all that the mirrored prediction needs are known, from what was new there.
/// |value| <= kMaxVertexValue; a decoder that meets a larger one, or the end of its bytes, fails and stops.
template <int kChannels, class Coder>
void code_values(Coder& coder, VertexValueModel<kChannels>& contexts, const Traversal& traversal,
                 std::vector<std::array<std::int32_t, kChannels>>& values, std::span<const std::uint32_t> mirror = {}) {
    constexpr int kLevels = VertexValueModel<kChannels>::kLevels;
    IntegerModel& model = contexts.model;
    std::vector<std::array<std::int32_t, kChannels>> residuals(values.size());
    std::array<std::int32_t, kChannels> last{};
    std::array<SideGain, kChannels> gains;
    for (SideGain& gain : gains) gain.product = gain.square;  // symmetric until seen otherwise
    std::vector<char> known(mirror.size(), 0);
    const auto mirrored = [&](const TraversalStep& step) {
        if (mirror.empty() || step.nearest == step.vertex || mirror[step.vertex] == step.vertex || !known[mirror[step.vertex]]) return false;
        if (step.count == 0) return known[mirror[step.nearest]] != 0;
        for (std::uint32_t i = step.first; i < step.first + step.count; ++i) {
            const Parallelogram& p = traversal.parallelograms[i];
            if (!known[mirror[p.a]] || !known[mirror[p.b]] || !known[mirror[p.c]]) return false;
        }
        return true;
    };
    const auto level = [](std::int64_t r) { return magnitude_level(std::uint32_t(std::min<std::int64_t>(std::abs(r), 1 << 26)), kLevels); };
    for (const TraversalStep& step : traversal.steps) {
        const auto base = predict<kChannels>(traversal, step, values);
        auto prediction = base;
        std::array<std::int64_t, kChannels> seen{};
        const bool both = mirrored(step);
        if (both) {
            const auto there = predict<kChannels>(traversal, step, values, mirror);
            for (int c = 0; c < kChannels; ++c) {
                const std::int64_t other = values[mirror[step.vertex]][std::size_t(c)];
                seen[std::size_t(c)] = (c == 0 ? -other : other) - there[std::size_t(c)];
                prediction[std::size_t(c)] += std::int32_t((seen[std::size_t(c)] * gains[std::size_t(c)].value() + SideGain::kOne / 2) >> 16);
            }
        }
        auto& residual = residuals[step.vertex];
        const int references = int(std::min<std::uint32_t>(step.count, 3)) * 2 + both;
        for (int c = 0; c < kChannels; ++c) {
            std::int64_t around = residuals[step.nearest][c];
            int neighbours = 1;
            if (step.nearest == step.vertex) around = 0;
            around = std::abs(around);
            for (std::uint32_t i = step.first; i < step.first + std::min<std::uint32_t>(step.count, 3); ++i) {
                const Parallelogram& p = traversal.parallelograms[i];
                around += std::abs(std::int64_t(residuals[p.a][c])) + std::abs(std::int64_t(residuals[p.b][c]));
                neighbours += 2;
            }
            const int near = level(2 * around / neighbours);
            const int own = c > 0 ? level(residual[c - 1]) : level(last[kChannels - 1]);
            std::int32_t r = 0;
            if constexpr (!Coder::kDecodes) r = std::int32_t(std::int64_t(values[step.vertex][c]) - prediction[c]);
            model.code(coder, r, {{c * 8 + references, (c * kLevels + near) * 2 + both, near * kLevels + own, level(last[c]) * 8 + references}, 0, c});
            residual[c] = r;
            if (Coder::kDecodes) {
                const std::int64_t value = std::int64_t(prediction[c]) + r;
                if (std::abs(value) > kMaxVertexValue) return coder.fail();
                values[step.vertex][c] = std::int32_t(value);
            }
            last[c] = r;
            if (both) gains[std::size_t(c)].learn(seen[std::size_t(c)], std::int64_t(values[step.vertex][std::size_t(c)]) - base[std::size_t(c)]);
        }
        if (!known.empty()) known[step.vertex] = 1;
        if (coder.failed()) return;
    }
}

}  // namespace mien::coding
