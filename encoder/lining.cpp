#include "encoder/lining.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

namespace {

/// From vertices that have a rim to all others that `paths` reach.
void grow(const Mesh& mesh, const SurfaceDistance& paths, std::vector<Rooted>& rooted) {
    std::vector<std::pair<std::uint32_t, float>> seeds;
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (rooted[v].rim != kNoRim) seeds.emplace_back(v, 0.0f);
    const auto neighbours = vertex_neighbours(mesh.vertex_count(), mesh.triangles);
    for (const auto& r : paths.from(seeds)) {
        if (rooted[r.vertex].rim != kNoRim) continue;
        float best = 1e9f;
        for (const std::uint32_t u : neighbours[r.vertex]) {
            if (rooted[u].rim == kNoRim) continue;
            const float way = rooted[u].depth + (mesh.positions.row(u) - mesh.positions.row(r.vertex)).norm();
            if (way < best) best = way, rooted[r.vertex] = {rooted[u].rim, way};
        }
    }
}

}  // namespace

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
    grow(mesh, lining, rooted);
    return rooted;
}

std::vector<Rooted> hang_on_skin(const Mesh& mesh, const std::vector<std::uint32_t>& skin, float reach) {
    constexpr float kRoot = 0.5f;  // mm further from the skin than the nearest of the piece
    constexpr std::uint32_t kHanging = 1u << int(Surface::lashes) | 1u << int(Surface::cornea) | 1u << int(Surface::hair) | 1u << int(Surface::other);
    const SurfaceDistance hanging(mesh, kHanging), all(mesh, ~0u), whole_skin(mesh, 1u << int(Surface::skin)), lashes(mesh, 1u << int(Surface::lashes));
    const auto V = mesh.vertex_count();
    std::vector<Rooted> rooted(V, Rooted{kNoRim, 0});
    if (skin.empty()) return rooted;
    Vec3 low = Vec3::Constant(1e9f), high = -low;
    for (const std::uint32_t u : skin) {
        low = low.cwiseMin(mesh.positions.row(u).transpose());
        high = high.cwiseMax(mesh.positions.row(u).transpose());
    }
    std::vector<float> away(V, 0);
    parallel_for(V, [&](std::int64_t i) {
        const auto v = std::uint32_t(i);
        if ((all.carries(v) && !hanging.carries(v)) || whole_skin.carries(v)) return;
        const Vec3 p = mesh.positions.row(v).transpose();
        if (((low - p).array() > reach).any() || ((p - high).array() > reach).any()) return;
        float least = reach * reach;
        for (const std::uint32_t u : skin)
            if (const float squared = (mesh.positions.row(u).transpose() - p).squaredNorm(); squared < least) least = squared, rooted[v].rim = u;
        away[v] = std::sqrt(least);
    });
    // A lash is thin and stands off: all of it turns with its root.
    const std::vector<Rooted> nearest = rooted;
    std::vector<Triangle> strips;
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    for (std::size_t t = 0; t < surfaces.size(); ++t)
        if (surfaces[t] == Surface::lashes) strips.push_back(mesh.triangles[t]);
    const auto neighbours = vertex_neighbours(V, strips);
    std::vector<char> seen(V);
    for (std::uint32_t seed = 0; seed < V; ++seed) {
        if (!lashes.carries(seed) || seen[seed]) continue;
        std::vector<std::uint32_t> piece{seed};
        seen[seed] = 1;
        float least = reach;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            if (rooted[piece[i]].rim != kNoRim) least = std::min(least, away[piece[i]]);
            for (const std::uint32_t n : neighbours[piece[i]])
                if (!std::exchange(seen[n], char(1))) piece.push_back(n);
        }
        for (const std::uint32_t v : piece)
            if (away[v] >= least + kRoot) rooted[v].rim = kNoRim;
    }
    grow(mesh, lashes, rooted);
    for (std::uint32_t v = 0; v < V; ++v)
        if (rooted[v].rim == kNoRim) rooted[v] = nearest[v];
    return rooted;
}

}  // namespace mien::encoder
