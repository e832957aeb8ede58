#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry.hpp"

namespace mien {

using Triangle = std::array<std::uint32_t, 3>;

/// What a run of triangles is made of. It decides shading and, for `skin`, where the texture video belongs.
enum class Surface : std::uint8_t { skin = 0, eye = 1, cornea = 2, teeth = 3, mouth = 4, lashes = 5, hair = 6, other = 7 };

/// A named run of triangles: first <= t < first + count.
struct MeshPart {
    std::string name;
    Surface surface = Surface::skin;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};

/// A triangle mesh, positions in mm. Texture coordinates have an index set of their own, as in OBJ, so that seams do
/// not split vertices; v = 0 is the bottom row of the image. Vertex and triangle order are part of the content.
struct Mesh {
    Points positions;                           ///< V x 3
    std::vector<Triangle> triangles;            ///< T
    std::vector<Vec2> texcoords;                ///< VT, may be empty
    std::vector<Triangle> texcoord_triangles;   ///< T, or empty when texcoords is
    /// V, or empty: the vertex that mirrors each from left to right (an involution; itself where there is none), as far as
    /// the mesh is built symmetrically. The shape itself need not be symmetric.
    std::vector<std::uint32_t> mirror;
    std::vector<MeshPart> parts;                ///< disjoint and in order, covering all triangles; empty: all skin

    std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(positions.rows()); }
    bool has_texcoords() const { return !texcoords.empty(); }
    /// The part's surface for every triangle; `skin` where no part says otherwise.
    std::vector<Surface> triangle_surfaces() const;
};

/// Area-weighted unit vertex normals, V x 3; zero for vertices of no triangle.
Points vertex_normals(PointsRef positions, const std::vector<Triangle>& triangles);

/// Vertices that share an edge with each vertex, sorted. V: number of vertices.
std::vector<std::vector<std::uint32_t>> vertex_neighbours(std::uint32_t V, const std::vector<Triangle>& triangles);

}  // namespace mien
