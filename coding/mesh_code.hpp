#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/byte_io.hpp"
#include "core/mesh.hpp"
#include "core/result.hpp"

/// The static mesh as bytes: connectivity, shape and texture coordinates are blobs of their own. Vertex and triangle order
/// survive. docs/format-model.md gives the bytes.
namespace mien::coding {

/// Triangles as they stand, order and first corner included. Every index < V.
Bytes encode_connectivity(std::uint32_t V, const std::vector<Triangle>& triangles);
struct Connectivity {
    std::uint32_t V = 0;
    std::vector<Triangle> triangles;
};
Result<Connectivity> decode_connectivity(ByteView bytes);

inline constexpr float kMaxSteps = 1 << 24;

/// Positions on a grid of `step` mm, predicted over the mesh and from side to side, the parts with their names, and the
/// mesh's mirror. step > 0; |position| / step < kMaxSteps.
Bytes encode_shape(const Mesh& mesh, float step);
/// Fills positions, mirror and parts of a mesh that has its triangles; V must agree with theirs.
Result<void> decode_shape(ByteView bytes, std::uint32_t V, Mesh& mesh);

/// Texture coordinates on a grid of 2^-16 and their triangles, predicted from the mesh's own.
Bytes encode_texcoords(const Mesh& mesh);
Result<void> decode_texcoords(ByteView bytes, Mesh& mesh);

}  // namespace mien::coding
