#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "coding/integer_model.hpp"
#include "coding/mesh_traversal.hpp"

namespace mien::coding {

inline constexpr std::int32_t kMaxVertexValue = 1 << 24;

/// Contexts of code_values; keep one over several sets of values of a kind and the later ones start warm.
template <int kChannels>
struct VertexValueModel {
    static constexpr int kLevels = 20;
    static constexpr int kLimit = 255;
    IntegerModel model{std::vector<int>{kChannels * 4, kChannels * kLevels, kLevels * kLevels, kLevels * 4}, 1, kChannels, kLimit};
};

/// Codes kChannels integers a vertex in traversal order, each as the difference from its prediction over the mesh.
/// |value| <= kMaxVertexValue; a decoder that meets a larger one, or the end of its bytes, fails and stops.
template <int kChannels, class Coder>
void code_values(Coder& coder, VertexValueModel<kChannels>& contexts, const Traversal& traversal,
                 std::vector<std::array<std::int32_t, kChannels>>& values) {
    constexpr int kLevels = VertexValueModel<kChannels>::kLevels;
    IntegerModel& model = contexts.model;
    std::vector<std::array<std::int32_t, kChannels>> residuals(values.size());
    std::array<std::int32_t, kChannels> last{};
    const auto level = [](std::int64_t r) { return magnitude_level(std::uint32_t(std::min<std::int64_t>(std::abs(r), 1 << 26)), kLevels); };
    for (const TraversalStep& step : traversal.steps) {
        const auto prediction = predict<kChannels>(traversal, step, values);
        auto& residual = residuals[step.vertex];
        const int known = int(std::min<std::uint32_t>(step.count, 3));
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
            model.code(coder, r, {{c * 4 + known, c * kLevels + near, near * kLevels + own, level(last[c]) * 4 + known}, 0, c});
            residual[c] = r;
            if (Coder::kDecodes) {
                const std::int64_t value = std::int64_t(prediction[c]) + r;
                if (std::abs(value) > kMaxVertexValue) return coder.fail();
                values[step.vertex][c] = std::int32_t(value);
            }
            last[c] = r;
        }
        if (coder.failed()) return;
    }
}

}  // namespace mien::coding
