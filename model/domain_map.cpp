#include "model/domain_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/parallel.hpp"
#include "core/surface_distance.hpp"

namespace mien::model {
namespace {

struct Place {
    float b1 = 0, b2 = 0, distance = std::numeric_limits<float>::infinity();  // distance in texture units
};

/// The point of triangle (p0, p1, p2) nearest to x.
Place nearest(const Vec2& p0, const Vec2& p1, const Vec2& p2, const Vec2& x) {
    const Vec2 a = p1 - p0, b = p2 - p0, d = x - p0;
    const float area = a.x() * b.y() - a.y() * b.x();
    if (std::abs(area) > 1e-14f) {
        const float b1 = (d.x() * b.y() - d.y() * b.x()) / area, b2 = (a.x() * d.y() - a.y() * d.x()) / area;
        if (b1 >= 0 && b2 >= 0 && b1 + b2 <= 1) return {b1, b2, 0};
    }
    Place best;
    const auto edge = [&](const Vec2& from, const Vec2& to, Vec2 from_weights, Vec2 to_weights) {
        const Vec2 way = to - from;
        const float s = way.squaredNorm() > 0 ? std::clamp((x - from).dot(way) / way.squaredNorm(), 0.0f, 1.0f) : 0;
        const float distance = (from + s * way - x).norm();
        const Vec2 weights = from_weights + s * (to_weights - from_weights);
        if (distance < best.distance) best = {weights.x(), weights.y(), distance};
    };
    edge(p0, p1, {0, 0}, {1, 0});
    edge(p1, p2, {1, 0}, {0, 1});
    edge(p2, p0, {0, 1}, {0, 0});
    return best;
}

/// Of (d1, d2) at a marker.
float domain_length(const DomainAxes& axes, const Deformations& S, Eigen::Index m) { return std::hypot(S.row(m).dot(axes.q.row(m)), S.row(m).dot(axes.r.row(m))); }

}  // namespace

std::vector<Vec2> site_texcoords(const Mesh& neutral, const std::vector<Site>& sites) {
    std::vector<std::vector<std::uint32_t>> around(neutral.vertex_count());
    for (std::uint32_t t = 0; t < neutral.triangles.size(); ++t)
        for (const std::uint32_t v : neutral.triangles[t]) around[v].push_back(t);
    std::vector<Vec2> places;
    for (const Site& site : sites) {
        Vec2 place = Vec2::Zero();
        for (const std::uint32_t t : around[site.vertices[0]]) {
            Vec2 sum = Vec2::Zero();
            float found = 0;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3 && site.weights[i] != 0; ++k)
                    if (neutral.triangles[t][k] == site.vertices[i]) {
                        sum += site.weights[i] * neutral.texcoords[neutral.texcoord_triangles[t][k]];
                        found += site.weights[i];
                        break;
                    }
            if (std::abs(found - 1) > 1e-3f) continue;
            place = sum;
            break;
        }
        places.push_back(place);
    }
    return places;
}

DomainMap make_domain_map(const Mesh& neutral, const TexelMap& texels, const std::vector<Site>& sites, const MarkerMesh& markers,
                          float reach, const std::vector<std::uint8_t>& wanted) {
    const std::uint32_t V = neutral.vertex_count();
    const std::vector<Vec2> uv = site_texcoords(neutral, sites);
    std::vector<std::vector<std::uint32_t>> around(sites.size());  // marker triangles
    for (std::uint32_t t = 0; t < markers.triangles.size(); ++t)
        for (const std::uint32_t m : markers.triangles[t]) around[m].push_back(t);

    // Marker nearest along the skin, for every vertex. A marker outside the mesh of triangles leads nowhere.
    const SurfaceDistance skin(neutral, 1u << int(Surface::skin));
    std::vector<float> distance(V, std::numeric_limits<float>::infinity());
    std::vector<std::uint32_t> nearest_marker(V, 0);
    for (std::uint32_t m = 0; m < sites.size(); ++m) {
        if (around[m].empty()) continue;
        std::vector<std::pair<std::uint32_t, float>> seeds;
        for (int i = 0; i < 3; ++i)
            if (sites[m].weights[i] > 0)
                seeds.emplace_back(sites[m].vertices[i],
                                   (neutral.positions.row(sites[m].vertices[i]) - markers.neutral.row(m)).norm());
        for (const auto& reached : skin.from(seeds, reach))
            if (reached.distance < distance[reached.vertex]) {
                distance[reached.vertex] = reached.distance;
                nearest_marker[reached.vertex] = m;
            }
    }

    // A texel inside a marker triangle is only taken there if one of that triangle's corners is near it along the skin:
    // where a cut makes the mesh overlap itself in texture space, the other side's triangles do not count.
    std::vector<std::vector<std::uint32_t>> candidates(sites.size());  // triangles within two edges of a marker
    for (std::size_t m = 0; m < sites.size(); ++m) {
        for (const std::uint32_t t : around[m])
            for (const std::uint32_t corner : markers.triangles[t])
                candidates[m].insert(candidates[m].end(), around[corner].begin(), around[corner].end());
        std::sort(candidates[m].begin(), candidates[m].end());
        candidates[m].erase(std::unique(candidates[m].begin(), candidates[m].end()), candidates[m].end());
    }
    struct Located {
        std::uint32_t triangle, place;
        float b1, b2;
    };
    std::vector<std::vector<Located>> rows(std::size_t(texels.height));
    parallel_for(texels.height, [&](std::int64_t y) {
        for (int x = 0; x < texels.width; ++x) {
            const TexelMap::Texel& texel = texels.at(x, int(y));
            const auto place = std::uint32_t(y * texels.width + x);
            if (texel.triangle == TexelMap::kNone || (!wanted.empty() && !wanted[place])) continue;
            const Triangle& corners = neutral.triangles[texel.triangle];
            std::uint32_t tried[3];
            int count = 0;
            for (const std::uint32_t v : corners)
                if (distance[v] <= reach && std::find(tried, tried + count, nearest_marker[v]) == tried + count) tried[count++] = nearest_marker[v];
            if (count == 0) continue;
            const Vec2 here((float(x) + 0.5f) / float(texels.width), 1 - (float(y) + 0.5f) / float(texels.height));
            Place best;
            std::uint32_t triangle = 0;
            for (int i = 0; i < count && best.distance > 0; ++i)
                for (const std::uint32_t t : candidates[tried[i]]) {
                    const Triangle& c = markers.triangles[t];
                    const Place there = nearest(uv[c[0]], uv[c[1]], uv[c[2]], here);
                    if (there.distance < best.distance) best = there, triangle = t;
                    if (best.distance == 0) break;
                }
            if (std::isfinite(best.distance)) rows[std::size_t(y)].push_back({triangle, place, best.b1, best.b2});
        }
    });
    std::vector<Located> all;
    for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
    std::stable_sort(all.begin(), all.end(), [](const Located& a, const Located& b) { return a.triangle < b.triangle; });

    DomainMap map;
    map.width = texels.width;
    map.height = texels.height;
    for (const Located& texel : all) {
        const auto i = std::uint32_t(map.place.size());
        if (map.runs.empty() || map.runs.back().triangle != texel.triangle) map.runs.push_back({texel.triangle, i, i});
        map.runs.back().end = i + 1;
        map.place.push_back(texel.place);
        map.b1.push_back(texel.b1);
        map.b2.push_back(texel.b2);
    }
    return map;
}

void add_extents(Eigen::VectorXf& longest, const DomainAxes& axes, const Deformations& S) {
    if (longest.size() == 0) longest = Eigen::VectorXf::Zero(S.rows());
    for (Eigen::Index m = 0; m < S.rows(); ++m) longest[m] = std::max(longest[m], domain_length(axes, S, m));
}

DomainParameters domain_parameters(const MarkerMesh& mesh, const DomainAxes& axes, const Deformations& measured) {
    assert(measured.rows() == mesh.neutral.rows() && axes.q.rows() == measured.rows() && axes.r.rows() == measured.rows());
    assert(axes.extents.size() == 0 || axes.extents.size() == measured.rows());
    DomainParameters parameters;
    // Squares and cubes of a marker that strays (a new extreme, a tracker's slip) would tear the skin; S itself shrinks, as it is what is interpolated.
    Deformations S = measured;
    for (Eigen::Index m = 0; m < axes.extents.size(); ++m)
        if (const float length = domain_length(axes, S, m); length > axes.extents[m]) S.row(m) *= axes.extents[m] / length;
    const auto product = [&](const Triangle& t, const Deformations& axis) {
        // (s0 + b1 s1 + b2 s2) . (a0 + b1 a1 + b2 a2)
        using Row = Eigen::Matrix<float, 1, kDeformationSize>;
        const Row s0 = S.row(t[0]), s1 = S.row(t[1]) - s0, s2 = S.row(t[2]) - s0;
        const Row a0 = axis.row(t[0]), a1 = axis.row(t[1]) - a0, a2 = axis.row(t[2]) - a0;
        return DomainParameters::Quadratic{{s0.dot(a0), s0.dot(a1) + s1.dot(a0), s0.dot(a2) + s2.dot(a0), s1.dot(a1),
                                            s1.dot(a2) + s2.dot(a1), s2.dot(a2)}};
    };
    for (const Triangle& t : mesh.triangles) {
        parameters.d1.push_back(product(t, axes.q));
        parameters.d2.push_back(product(t, axes.r));
    }
    return parameters;
}

}  // namespace mien::model
