#include "coding/point_order.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace mien::coding {
namespace {

struct Graph {
    std::vector<std::uint32_t> first, neighbours;

    Graph(std::uint32_t points, std::span<const Triangle> triangles) : first(points + 1, 0) {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
        edges.reserve(triangles.size() * 6);
        for (const Triangle& t : triangles) {
            if (t[0] >= points || t[1] >= points || t[2] >= points) continue;
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t a = t[std::size_t(i)], b = t[std::size_t((i + 1) % 3)];
                if (a == b) continue;
                edges.push_back({a, b});
                edges.push_back({b, a});
            }
        }
        std::sort(edges.begin(), edges.end());
        edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
        neighbours.reserve(edges.size());
        for (const auto& [a, b] : edges) {
            ++first[a + 1];
            neighbours.push_back(b);
        }
        std::partial_sum(first.begin(), first.end(), first.begin());
    }
    std::span<const std::uint32_t> of(std::uint32_t p) const {
        return {neighbours.data() + first[p], neighbours.data() + first[p + 1]};
    }
};

// Weight of a reference at a distance in edges: about 1 / distance^2.
constexpr std::array<std::int32_t, 33> kWeight = [] {
    std::array<std::int32_t, 33> weight{};
    for (int d = 1; d <= 32; ++d) weight[std::size_t(d)] = std::max(1, 1024 / (d * d));
    return weight;
}();
constexpr std::size_t kMaxReferences = 6;
constexpr std::size_t kMaxVisited = 256;  // bounds the search around points of absurd degree

}  // namespace

PointOrder plain_order(std::uint32_t points) {
    PointOrder out;
    out.order.resize(points);
    std::iota(out.order.begin(), out.order.end(), 0u);
    out.level.assign(points, 0);
    out.first.assign(points + 1, 0);
    out.partner = out.order;
    return out;
}

PointOrder parent_order(std::span<const std::uint32_t> parents) {
    PointOrder out = plain_order(std::uint32_t(parents.size()));
    for (std::uint32_t i = 0; i < parents.size(); ++i) {
        if (parents[i] < i) out.references.push_back({parents[i], 1});
        out.first[i + 1] = std::uint32_t(out.references.size());
    }
    return out;
}

PointOrder mesh_order(std::uint32_t points, std::span<const Triangle> triangles, std::span<const std::uint32_t> mirror) {
    const Graph graph(points, triangles);
    PointOrder out;
    out.order.reserve(points);
    out.first.push_back(0);

    std::vector<std::uint8_t> chosen(points, 0);
    std::vector<std::uint8_t> reach(points, 0);  // how many edges further a chosen point's circle still covers
    std::vector<std::uint32_t> queue;
    for (int level = PointOrder::kLevels - 3; level >= 0; --level) {
        const int radius = (1 << level) - 1;
        std::fill(reach.begin(), reach.end(), std::uint8_t(0));
        const auto cover = [&](std::uint32_t centre) {
            if (reach[centre] > radius) return;
            reach[centre] = std::uint8_t(radius + 1);
            queue.assign(1, centre);
            for (std::size_t head = 0; head < queue.size(); ++head) {
                const std::uint32_t p = queue[head];
                if (reach[p] < 2) continue;
                for (std::uint32_t q : graph.of(p))
                    if (reach[q] + 1 < reach[p]) {
                        reach[q] = std::uint8_t(reach[p] - 1);
                        queue.push_back(q);
                    }
            }
        };
        for (std::uint32_t p : out.order) cover(p);
        for (std::uint32_t p = 0; p < points; ++p) {
            if (chosen[p] || reach[p]) continue;
            const auto choose = [&](std::uint32_t q) {
                chosen[q] = 1;
                out.order.push_back(q);
                out.level.push_back(std::uint8_t(level));
                cover(q);
            };
            choose(p);
            // Its mirror comes next, so that what was new at one side can be expected at the other.
            if (!mirror.empty() && !chosen[mirror[p]]) choose(mirror[p]);
        }
    }

    // References: breadth first from each point over everything, taking the nearest points coded before.
    std::vector<std::uint32_t> position(points);
    for (std::uint32_t i = 0; i < points; ++i) position[out.order[i]] = i;
    std::vector<std::uint32_t> seen(points, 0xffffffffu);
    std::vector<std::uint8_t> distance(points, 0);
    for (std::uint32_t i = 0; i < points; ++i) {
        const int reach_limit = std::min(32, 2 << out.level[i]);
        const std::size_t begin = out.references.size();
        out.partner.push_back(out.order[i]);
        if (!mirror.empty() && mirror[out.order[i]] != out.order[i] && position[mirror[out.order[i]]] < i) {
            const std::uint32_t other = mirror[out.order[i]];
            out.partner.back() = other;
            if (position[other] + 1 == i) {
                // The same references seen in the mirror, so that what is left looks the same too.
                const std::size_t from = out.first[i - 1];
                bool known = true;
                for (std::size_t r = from; r < begin; ++r) known &= position[mirror[out.references[r].point]] < i;
                if (known) {
                    for (std::size_t r = from; r < begin; ++r)
                        out.references.push_back({mirror[out.references[r].point], out.references[r].weight});
                    out.first.push_back(std::uint32_t(out.references.size()));
                    continue;
                }
            }
        }
        queue.assign(1, out.order[i]);
        seen[out.order[i]] = i;
        distance[out.order[i]] = 0;
        int last = reach_limit;
        const std::size_t visit_limit = kMaxVisited << (2 * std::min<int>(out.level[i], 3));
        for (std::size_t head = 0; head < queue.size() && queue.size() < visit_limit; ++head) {
            const std::uint32_t p = queue[head];
            if (distance[p] >= last) break;
            for (std::uint32_t q : graph.of(p)) {
                if (seen[q] == i) continue;
                seen[q] = i;
                distance[q] = std::uint8_t(distance[p] + 1);
                queue.push_back(q);
                if (position[q] < i && out.references.size() - begin < kMaxReferences) {
                    out.references.push_back({q, kWeight[distance[q]]});
                    // One ring beyond the first find is enough: farther points only blur.
                    last = std::min(last, distance[q] + 1);
                }
                if (queue.size() >= visit_limit) break;
            }
        }
        out.first.push_back(std::uint32_t(out.references.size()));
    }
    return out;
}

}  // namespace mien::coding
