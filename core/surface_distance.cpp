#include "core/surface_distance.hpp"

#include <algorithm>
#include <queue>

namespace mien {

SurfaceDistance::SurfaceDistance(const Mesh& mesh, std::uint32_t surfaces) {
    const std::vector<Surface> surface_of = mesh.triangle_surfaces();
    using Pair = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Pair> links;
    std::vector<std::pair<Pair, std::uint32_t>> opposite;  // edge -> the corner across it
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!(surfaces >> int(surface_of[t]) & 1)) continue;
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
            if (a == b) continue;
            links.emplace_back(a, b);
            opposite.push_back({std::minmax(a, b), mesh.triangles[t][(i + 2) % 3]});
        }
    }
    std::sort(opposite.begin(), opposite.end());
    for (std::size_t i = 1; i < opposite.size(); ++i)
        if (opposite[i].first == opposite[i - 1].first && opposite[i].second != opposite[i - 1].second)
            links.emplace_back(opposite[i - 1].second, opposite[i].second);
    const std::size_t one_way = links.size();
    for (std::size_t i = 0; i < one_way; ++i) links.emplace_back(links[i].second, links[i].first);
    std::sort(links.begin(), links.end());
    links.erase(std::unique(links.begin(), links.end()), links.end());

    start_.assign(mesh.vertex_count() + 1, 0);
    arcs_.reserve(links.size());
    for (const auto& [from, to] : links) {
        ++start_[from + 1];
        arcs_.emplace_back(to, (mesh.positions.row(from) - mesh.positions.row(to)).norm());
    }
    for (std::size_t v = 0; v + 1 < start_.size(); ++v) start_[v + 1] += start_[v];
}

std::vector<SurfaceDistance::Reached> SurfaceDistance::from(const std::vector<std::pair<std::uint32_t, float>>& seeds,
                                                            float limit) const {
    using Entry = std::pair<float, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
    std::vector<float> best(start_.size() - 1, std::numeric_limits<float>::infinity());
    for (const auto& [vertex, distance] : seeds)
        if (distance < best[vertex]) {
            best[vertex] = distance;
            front.emplace(distance, vertex);
        }
    std::vector<Reached> reached;
    while (!front.empty()) {
        const auto [distance, vertex] = front.top();
        front.pop();
        if (distance > best[vertex]) continue;
        if (distance > limit) break;
        reached.push_back({vertex, distance});
        for (std::uint32_t i = start_[vertex]; i < start_[vertex + 1]; ++i) {
            const auto& [to, length] = arcs_[i];
            if (distance + length < best[to]) {
                best[to] = distance + length;
                front.emplace(best[to], to);
            }
        }
    }
    return reached;
}

}  // namespace mien
