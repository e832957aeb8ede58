#pragma once

#include <filesystem>

#include "core/hash.hpp"
#include "io/mesh_file.hpp"

namespace mien::io {

/// glTF 2.0, binary (GLB) or JSON with its buffers beside it (`folder`; data: URIs too): all triangle primitives the scene shows, by its
/// nodes' transforms, one MeshPart each; morph targets as blendshapes when there is one mesh; plain and quantised accessors.
/// Vertices split at texture seams stay split. Errors: bad_magic, truncated, damaged, limit_exceeded; invalid for compressed
/// geometry (EXT_meshopt_compression, KHR_draco_mesh_compression), saying how to save without.
Result<MeshFile> parse_gltf(ByteView bytes, const std::filesystem::path& folder = {});
Result<MeshFile> read_gltf(const std::filesystem::path& path);

}  // namespace mien::io
