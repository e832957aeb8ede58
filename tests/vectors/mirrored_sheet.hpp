#pragma once

#include <cmath>

#include "core/mesh.hpp"

namespace mien::vectors {

/// A bumpy sheet around x = 0, built symmetrically, its shape not quite so: `half` columns of squares each side, `rows` of vertices.
/// Texture coordinates have a seam along the middle. The last row of squares is a part of its own.
inline Mesh mirrored_sheet(std::uint32_t half, std::uint32_t rows) {
    const std::uint32_t side = 2 * half + 1;
    Mesh mesh;
    mesh.positions.resize(side * rows, 3);
    const auto place = [&](std::uint32_t x, std::uint32_t y) { return Vec2(float(x) / float(side), float(y) / float(rows)); };
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < side; ++x) {
            const float across = 4 * (float(x) - float(half));
            mesh.positions.row(y * side + x) << across, 5 * float(y), 6 * std::cos(0.1f * across) + std::sin(float(y)) + (x > half && (x + y) % 4 == 1 ? 0.2f : 0.0f);
            mesh.texcoords.push_back(place(x, y));
        }
    for (std::uint32_t y = 0; y < rows; ++y) mesh.texcoords.push_back(place(half, y) + Vec2(0.01f, 0));   // the seam's other side
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, bool right) {
        mesh.triangles.push_back({a, b, c});
        Triangle there{a, b, c};
        for (std::uint32_t& v : there)
            if (right && v % side == half) v = side * rows + v / side;
        mesh.texcoord_triangles.push_back(there);
    };
    std::uint32_t before_last = 0;
    for (std::uint32_t y = 0; y + 1 < rows; ++y) {
        if (y + 2 == rows) before_last = std::uint32_t(mesh.triangles.size());
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x, b = a + 1, c = a + side, d = c + 1;
            if (x < half) add(a, b, c, false), add(b, d, c, false);
            else add(a, b, d, true), add(a, d, c, true);   // the diagonal mirrored
        }
    }
    mesh.parts = {{"face", Surface::skin, 0, before_last}, {"collar", Surface::other, before_last, std::uint32_t(mesh.triangles.size()) - before_last}};
    return mesh;
}

}  // namespace mien::vectors
