#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/clip.hpp"

namespace mien::io {

struct MeshFile {
    Mesh mesh;                             ///< in the file's unit
    std::vector<Blendshape> blendshapes;   ///< morph targets of a GLB
    std::vector<std::string> warnings;
};

/// OBJ, PLY, GLB or glTF, by the name's ending.
Result<MeshFile> read_mesh(const std::filesystem::path& path);
/// Positions alone, OBJ or PLY: one frame of a numbered sequence.
Result<Points> read_positions(const std::filesystem::path& path);

}  // namespace mien::io
