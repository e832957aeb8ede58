#pragma once

#include <vector>

#include "core/mesh.hpp"

/// What lies behind the skin: walls that grow from it, and pieces of bone.
namespace mien::encoder {

/// Heights of the connected piece that a vertex belongs to: they tell the upper teeth from the lower.
struct Piece {
    float mean, low, high;  ///< mm
};
/// For every vertex, V.
std::vector<Piece> connected_pieces(const Mesh& mesh);

inline constexpr std::uint32_t kNoRim = 0xffffffffu;

/// Where lining (Surface::mouth: walls of the mouth, sockets of the eyes) grows from.
struct Rooted {
    std::uint32_t rim;  ///< the skin vertex from which the lining reaches this one first; kNoRim: not lining, nothing hanging
    float depth;        ///< mm along the lining or piece
};
/// For every vertex, V. skin: vertices that lining may grow from; it shares them or is sewn on within 0.1 mm.
std::vector<Rooted> grow_lining(const Mesh& mesh, const std::vector<std::uint32_t>& skin);

/// Where what stands on the skin hangs: lashes on the skin nearest to the root of their connected piece, tear film, hair and the like, and
/// vertices of no triangle, each on the nearest skin. For every vertex, V. skin: as above; what is `reach` mm from it or more hangs on nothing,
/// but for lashes whose root is nearer.
std::vector<Rooted> hang_on_skin(const Mesh& mesh, const std::vector<std::uint32_t>& skin, float reach);

}  // namespace mien::encoder
