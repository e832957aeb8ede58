#pragma once

#include <algorithm>
#include <numeric>
#include <random>

#include "core/byte_io.hpp"
#include "core/mesh.hpp"

namespace mien {

/// A bumpy sheet of side x side vertices with texture coordinates, in rows.
inline Mesh sheet(std::uint32_t side) {
    Mesh mesh;
    mesh.positions.resize(side * side, 3);
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
            mesh.positions.row(y * side + x) << 2.0f * float(x), 2.0f * float(y), 3 * std::sin(0.7f * float(x)) * std::cos(0.5f * float(y));
            mesh.texcoords.emplace_back(float(x) / float(side), float(y) / float(side));
        }
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            mesh.triangles.push_back({a, a + 1, a + side});
            mesh.triangles.push_back({a + 1, a + side + 1, a + side});
        }
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

/// The same surface with vertices, texture coordinates, triangles and first corners in any order.
inline Mesh shuffled(const Mesh& mesh, unsigned seed) {
    std::mt19937 random(seed);
    const auto order = [&](std::size_t n) {
        std::vector<std::uint32_t> to(n);
        std::iota(to.begin(), to.end(), 0u);
        std::shuffle(to.begin(), to.end(), random);
        return to;
    };
    Mesh out = mesh;
    const auto vertex = order(mesh.vertex_count()), texcoord = order(mesh.texcoords.size()), triangle = order(mesh.triangles.size());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) out.positions.row(vertex[v]) = mesh.positions.row(v);
    for (std::size_t v = 0; v < mesh.texcoords.size(); ++v) out.texcoords[texcoord[v]] = mesh.texcoords[v];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::size_t turn = random() % 3;
        for (std::size_t i = 0; i < 3; ++i) {
            out.triangles[triangle[t]][i] = vertex[mesh.triangles[t][(i + turn) % 3]];
            if (mesh.has_texcoords()) out.texcoord_triangles[triangle[t]][i] = texcoord[mesh.texcoord_triangles[t][(i + turn) % 3]];
        }
    }
    return out;
}

/// Calls `decode` with every truncation of `bytes`, and with every byte changed in three ways.
template <class Decode>
void for_all_damage(const Bytes& bytes, Decode decode) {
    for (std::size_t size = 0; size < bytes.size(); ++size) decode(ByteView(bytes).first(size), true);
    for (std::size_t at = 0; at < bytes.size(); ++at)
        for (const unsigned flip : {0x01u, 0x80u, 0xffu}) {
            Bytes damaged = bytes;
            damaged[at] ^= std::byte(flip);
            decode(ByteView(damaged), false);
        }
}

}  // namespace mien
