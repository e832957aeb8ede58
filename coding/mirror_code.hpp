#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "coding/integer_model.hpp"
#include "core/mesh.hpp"

namespace mien::coding {

/// Codes which vertex mirrors which (Mesh::mirror): over the mesh, breadth first, where the neighbours' partners say whom to
/// expect. A mesh that is built symmetrically costs some hundredths of a bit a vertex. Always an involution, whatever the bytes.
template <class Coder>
void code_mirror(Coder& coder, const std::vector<std::vector<std::uint32_t>>& neighbours, std::vector<std::uint32_t>& mirror) {
    constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();
    constexpr std::size_t kAsked = 8, kOffered = 16;   // bound what is looked at around vertices of absurd degree
    const auto V = std::uint32_t(neighbours.size());
    std::vector<std::uint32_t> known(V, kUnknown);
    std::array<AdaptiveBit, 4> expected;
    std::array<AdaptiveBit, 4> alone;
    std::vector<char> queued(V, 0);
    std::vector<std::uint32_t> queue;
    std::vector<std::pair<std::uint32_t, int>> candidates;
    for (std::uint32_t seed = 0; seed < V; ++seed) {
        if (queued[seed]) continue;
        queue.assign(1, seed);
        queued[seed] = 1;
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const std::uint32_t v = queue[head];
            for (const std::uint32_t n : neighbours[v])
                if (!queued[n]) queued[n] = 1, queue.push_back(n);
            if (known[v] != kUnknown) continue;
            // Neighbours of the neighbours' partners, the most often named first.
            candidates.clear();
            for (std::size_t i = 0; i < std::min(kAsked, neighbours[v].size()); ++i) {
                const std::uint32_t partner = known[neighbours[v][i]];
                if (partner == kUnknown) continue;
                for (std::size_t j = 0; j < std::min(kOffered, neighbours[partner].size()); ++j) {
                    const std::uint32_t offered = neighbours[partner][j];
                    if (known[offered] != kUnknown) continue;
                    const auto at = std::find_if(candidates.begin(), candidates.end(), [&](const auto& c) { return c.first == offered; });
                    if (at == candidates.end()) candidates.push_back({offered, 1});
                    else ++at->second;
                }
            }
            const auto best = std::max_element(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
                return a.second != b.second ? a.second < b.second : a.first > b.first;
            });
            const int votes = best == candidates.end() ? 0 : std::min(best->second, 3);
            int hit = 0;
            if (votes > 0) {
                if constexpr (!Coder::kDecodes) hit = mirror[v] == best->first;
                expected[std::size_t(votes)].code(coder, hit);
            }
            std::uint32_t partner = hit ? best->first : v;
            if (!hit) {
                int self = 0;
                if constexpr (!Coder::kDecodes) self = mirror[v] == v;
                alone[std::size_t(votes)].code(coder, self);
                if (!self) {
                    if constexpr (!Coder::kDecodes) partner = mirror[v];
                    code_plain(coder, partner, int(std::bit_width(V)));
                    if (partner >= V || known[partner] != kUnknown) return coder.fail();
                }
            }
            known[v] = partner;
            known[partner] = v;
        }
        if (coder.failed()) return;
    }
    mirror = std::move(known);
}

}  // namespace mien::coding
