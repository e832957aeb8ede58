#include "analysis/texture_triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/delaunay.hpp"
#include "core/parallel.hpp"
#include "core/surface_distance.hpp"
#include "model/domain_map.hpp"

namespace mien::analysis {
namespace {

constexpr float kDetour = 1.5f;  // along the skin over straight; a bent cheek stays below 1.2, lids are above even near their corners
constexpr float kLongest = 3.5f; // medians of the longest sides

}  // namespace

std::vector<Triangle> triangulate_over_texture(const Mesh& neutral, const std::vector<Site>& sites) {
    if (sites.size() < 3) return {};
    std::vector<Eigen::Vector2d> places;
    for (const Vec2& uv : model::site_texcoords(neutral, sites)) places.push_back(1000 * uv.cast<double>());
    std::vector<Triangle> triangles = delaunay(std::move(places));
    if (triangles.empty()) return {};

    const auto position = [&](std::uint32_t m) { return sites[m].position(neutral.positions); };
    const auto longest = [&](const Triangle& t) {
        float most = 0;
        for (int e = 0; e < 3; ++e) most = std::max(most, (position(t[e]) - position(t[(e + 1) % 3])).norm());
        return most;
    };
    std::vector<float> lengths;
    for (const Triangle& t : triangles) lengths.push_back(longest(t));
    std::nth_element(lengths.begin(), lengths.begin() + long(lengths.size() / 2), lengths.end());
    const float limit = kLongest * lengths[lengths.size() / 2];

    const SurfaceDistance skin(neutral, 1u << int(Surface::skin));
    std::vector<std::vector<std::uint32_t>> beside = vertex_neighbours(std::uint32_t(sites.size()), triangles);
    std::vector<std::vector<char>> joined(sites.size());  // as beside
    parallel_for(std::int64_t(sites.size()), [&](std::int64_t m) {
        const Site& site = sites[std::size_t(m)];
        std::vector<float> distance(neutral.vertex_count(), std::numeric_limits<float>::infinity());
        std::vector<std::pair<std::uint32_t, float>> seeds;
        for (int i = 0; i < 3; ++i)
            if (site.weights[i] > 0)
                seeds.emplace_back(site.vertices[i], (neutral.positions.row(site.vertices[i]).transpose() - position(std::uint32_t(m))).norm());
        for (const auto& reached : skin.from(seeds, kDetour * limit)) distance[reached.vertex] = reached.distance;
        for (const std::uint32_t other : beside[std::size_t(m)]) {
            const Vec3 there = position(other);
            float along = std::numeric_limits<float>::infinity();
            for (int i = 0; i < 3; ++i)
                if (sites[other].weights[i] > 0) {
                    const std::uint32_t v = sites[other].vertices[i];
                    along = std::min(along, distance[v] + (neutral.positions.row(v).transpose() - there).norm());
                }
            joined[std::size_t(m)].push_back(along <= kDetour * (there - position(std::uint32_t(m))).norm());
        }
    });
    std::erase_if(triangles, [&](const Triangle& t) {
        if (longest(t) > limit) return true;
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t a = t[e], b = t[(e + 1) % 3];
            const auto at = std::lower_bound(beside[a].begin(), beside[a].end(), b) - beside[a].begin();
            if (!joined[a][std::size_t(at)]) return true;
        }
        return false;
    });
    return triangles;
}

}  // namespace mien::analysis
