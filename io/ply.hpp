#pragma once

#include <filesystem>

#include "core/hash.hpp"
#include "core/mesh.hpp"
#include "core/result.hpp"

namespace mien::io {

/// PLY, ASCII or binary of either byte order: vertex x y z and, where there, texture coordinates per vertex (s t, u v, texture_u
/// texture_v) or per face corner (texcoord); faces of any size become fans. Other properties and elements are skipped.
/// In text, as by the format, every vertex and face has a line of its own. Errors: bad_magic, truncated, limit_exceeded, invalid naming all
/// that is wrong, in text by line.
Result<Mesh> parse_ply(ByteView bytes);
Result<Mesh> read_ply(const std::filesystem::path& path);

}  // namespace mien::io
