#include "io/mesh_file.hpp"

#include <fmt/format.h>

#include "io/file.hpp"
#include "io/gltf.hpp"
#include "io/obj.hpp"
#include "io/ply.hpp"
#include "io/text.hpp"

namespace mien::io {

Result<MeshFile> read_mesh(const std::filesystem::path& path) {
    const std::string ending = lower_case(path.extension().string());
    if (ending == ".glb" || ending == ".gltf") return read_gltf(path);
    if (ending == ".obj" || ending == ".ply") {
        MIEN_TRY(mesh, ending == ".obj" ? read_obj(path) : read_ply(path));
        return MeshFile{std::move(mesh), {}, {}};
    }
    return Error{ErrorCode::invalid, fmt::format("{}: meshes come as .obj, .ply, .glb or .gltf", path.string())};
}

Result<Points> read_positions(const std::filesystem::path& path) {
    if (lower_case(path.extension().string()) == ".obj") {
        MIEN_TRY(text, read_text(path));
        auto positions = parse_obj_positions(text);
        if (!positions) return in_file(path, positions.error());
        return positions;
    }
    MIEN_TRY(file, read_mesh(path));
    return std::move(file.mesh.positions);
}

}  // namespace mien::io
