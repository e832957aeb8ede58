#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace mien {

/// Which place of the mesh every texel shows: the "geometry map" of Guenter et al. 1998, section 6.
struct TexelMap {
    static constexpr std::uint32_t kNone = 0xffffffffu;
    struct Texel {
        std::uint32_t triangle = kNone;
        float b1 = 0, b2 = 0;  ///< barycentric weights of the triangle's second and third corner
    };
    int width = 0;
    int height = 0;
    std::vector<Texel> texels;  ///< rows from the top

    const Texel& at(int x, int y) const { return texels[std::size_t(y) * width + x]; }
    bool used(int x, int y) const { return at(x, y).triangle != kNone; }
};

/// Texel centres covered by the mesh's texture triangles; where triangles overlap, the first one counts.
/// `surfaces`: bit s set takes triangles of Surface(s); default all. An image is width x height texels, v = 1 at its top.
TexelMap make_texel_map(const Mesh& mesh, int width, int height, std::uint32_t surfaces = 0xffffffffu);

}  // namespace mien
