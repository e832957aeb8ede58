#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh.hpp"

namespace mien::coding {

/// One vertex in the order in which both sides code per-vertex values, with what is known by then to predict it from.
struct TraversalStep {
    std::uint32_t vertex = 0;
    std::uint32_t first = 0;   ///< its parallelograms are Traversal::parallelograms[first .. first + count)
    std::uint32_t count = 0;
    std::uint32_t nearest = 0; ///< a vertex coded earlier (an edge neighbour when there is one); itself for the very first
};

/// A vertex opposite to `c` across edge (a, b) lies near a + b - c.
struct Parallelogram {
    std::uint32_t a, b, c;
};

/// A walk over all vertices of a mesh that depends on connectivity alone, so encoder and decoder share it whatever the
/// vertex order is. The next vertex is always one with most triangles whose other two corners are known
/// (prediction-degree traversal), the earliest found first.
struct Traversal {
    std::vector<TraversalStep> steps;           ///< V, every vertex once
    std::vector<Parallelogram> parallelograms;
};

Traversal traverse(std::uint32_t V, const std::vector<Triangle>& triangles);

/// Mean of the step's parallelograms, or the nearest known value, per channel, rounded to integers.
/// values: channels integers per vertex; only those of earlier steps are read. mirror: when not empty, as the same prediction
/// looks from the other side: every vertex is the one that mirrors it, and the first channel, x, is negated.
template <int kChannels>
std::array<std::int32_t, kChannels> predict(const Traversal& traversal, const TraversalStep& step,
                                            const std::vector<std::array<std::int32_t, kChannels>>& values,
                                            std::span<const std::uint32_t> mirror = {}) {
    const auto value = [&](std::uint32_t v, int c) {
        if (mirror.empty()) return std::int64_t(values[v][std::size_t(c)]);
        const std::int64_t other = values[mirror[v]][std::size_t(c)];
        return c == 0 ? -other : other;
    };
    std::array<std::int32_t, kChannels> prediction{};
    if (step.count == 0) {
        if (step.nearest != step.vertex)
            for (int c = 0; c < kChannels; ++c) prediction[std::size_t(c)] = std::int32_t(value(step.nearest, c));
        return prediction;
    }
    for (int c = 0; c < kChannels; ++c) {
        std::int64_t sum = 0;
        for (std::uint32_t i = step.first; i < step.first + step.count; ++i) {
            const Parallelogram& p = traversal.parallelograms[i];
            sum += value(p.a, c) + value(p.b, c) - value(p.c, c);
        }
        const std::int64_t n = step.count;
        const std::int64_t doubled = 2 * sum + n;  // rounds to nearest, halves up
        prediction[std::size_t(c)] = static_cast<std::int32_t>(doubled >= 0 ? doubled / (2 * n) : -((-doubled + 2 * n - 1) / (2 * n)));
    }
    return prediction;
}

}  // namespace mien::coding
