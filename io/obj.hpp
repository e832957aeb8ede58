#pragma once

#include <filesystem>
#include <string_view>

#include "core/mesh.hpp"
#include "core/result.hpp"

namespace mien::io {

/// Wavefront OBJ: v, vt, f (polygons become fans in place, so that order is kept; negative indices count back), and
/// usemtl, g, o as MeshParts whose Surface is guessed from the names. Everything else is skipped. Lengths stay in the file's
/// unit. If only some faces have texture coordinates, the others share one point of their own, so they cover no texel.
/// Errors: invalid naming the lines (bad number, index out of range), and all vertices that are not finite with the first one's line;
/// limit_exceeded.
Result<Mesh> parse_obj(std::string_view text);
Result<Mesh> read_obj(const std::filesystem::path& path);

/// Only the v lines, in order: one frame of a numbered sequence, when the connectivity is known.
Result<Points> parse_obj_positions(std::string_view text);

/// Writes `mesh` with every position divided by `unit_mm` (10 writes centimetres). A part becomes "g NAME", and a
/// "usemtl mien_SURFACE" line where the name alone would be guessed as another surface; read_obj takes both back.
/// Throws EnvironmentError.
void write_obj(const std::filesystem::path& path, const Mesh& mesh, double unit_mm = 1);

}  // namespace mien::io
