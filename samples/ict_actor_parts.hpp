#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "core/result.hpp"
#include "samples/actor.hpp"

/// What is known about the topology of the ICT-FaceKit head.
namespace mien::samples::ict {

inline constexpr std::uint32_t kVertices = 26719;
inline constexpr std::uint32_t kFaceEnd = 9409;         ///< vertices of the face proper are [0, kFaceEnd)
inline constexpr std::uint32_t kSkinEnd = 11248;        ///< face, back of the head and neck
inline constexpr std::uint32_t kMouthSocketEnd = 13294;
inline constexpr std::uint32_t kSocketEnd = 14062;      ///< eye sockets
inline constexpr std::uint32_t kEyeball[2][2] = {{23021, 24591}, {21451, 23021}};  ///< right, left: first and end

/// The mesh as the OBJ file has it (parts named by material) -> parts in a fixed order, one texture atlas, mm.
Result<Mesh> arrange(const Mesh& file);

/// Features of a neutral face of this topology, positions in mm.
Landmarks find_landmarks(const Mesh& neutral);

}  // namespace mien::samples::ict
