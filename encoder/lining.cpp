#include "encoder/lining.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "core/surface_distance.hpp"

namespace mien::encoder {

std::vector<Piece> connected_pieces(const Mesh& mesh) {
    const auto neighbours = vertex_neighbours(mesh.vertex_count(), mesh.triangles);
    std::vector<Piece> piece_of(mesh.vertex_count());
    std::vector<char> seen(mesh.vertex_count());
    for (std::uint32_t seed = 0; seed < mesh.vertex_count(); ++seed) {
        if (seen[seed]) continue;
        std::vector<std::uint32_t> members{seed};
        seen[seed] = 1;
        Piece piece{0, 1e9f, -1e9f};
        double sum = 0;
        for (std::size_t i = 0; i < members.size(); ++i) {
            const float y = mesh.positions(members[i], 1);
            sum += y;
            piece.low = std::min(piece.low, y);
            piece.high = std::max(piece.high, y);
            for (const std::uint32_t n : neighbours[members[i]])
                if (!seen[n]) {
                    seen[n] = 1;
                    members.push_back(n);
                }
        }
        piece.mean = float(sum / double(members.size()));
        for (const std::uint32_t v : members) piece_of[v] = piece;
    }
    return piece_of;
}

std::vector<Rooted> grow_lining(const Mesh& mesh, const std::vector<std::uint32_t>& skin) {
    constexpr float kTouch = 0.1f;  // mm; linings may be meshes of their own, sewn on
    const SurfaceDistance lining(mesh, 1u << int(Surface::mouth));
    const auto position = [&](std::uint32_t v) -> Vec3 { return mesh.positions.row(v).transpose(); };
    std::vector<Rooted> rooted(mesh.vertex_count(), Rooted{kNoRim, 0});
    parallel_for(mesh.vertex_count(), [&](std::int64_t i) {
        const auto v = std::uint32_t(i);
        if (!lining.carries(v)) return;
        for (const std::uint32_t u : skin)
            if ((position(u) - position(v)).squaredNorm() < kTouch * kTouch) {
                rooted[v].rim = u;
                return;
            }
    });
    std::vector<std::pair<std::uint32_t, float>> seeds;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (rooted[v].rim != kNoRim) seeds.emplace_back(v, 0.0f);
    const auto neighbours = vertex_neighbours(mesh.vertex_count(), mesh.triangles);
    for (const auto& r : lining.from(seeds)) {
        if (rooted[r.vertex].rim != kNoRim) continue;
        float best = 1e9f;
        for (const std::uint32_t u : neighbours[r.vertex]) {
            if (rooted[u].rim == kNoRim) continue;
            const float way = rooted[u].depth + (position(u) - position(r.vertex)).norm();
            if (way < best) best = way, rooted[r.vertex] = {rooted[u].rim, way};
        }
    }
    return rooted;
}

}  // namespace mien::encoder
