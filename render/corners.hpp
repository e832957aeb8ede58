#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "model/face_model.hpp"

namespace mien::render {

/// What a vertex shader gets per corner: a vertex with one of its texture coordinates.
struct Corner {
    std::uint32_t vertex = 0;
    float u = 0, v = 0;
    float feature[4] = {0, 0, 0, 1};   ///< eyeball or mouth it belongs to: centre and radius, mm, head space
};

/// Triangles of one surface, drawn with one shader variant.
struct Batch {
    Surface surface = Surface::skin;
    bool textured = false;             ///< has texture coordinates inside the picture
    std::uint32_t first = 0;           ///< index into Corners::indices
    std::uint32_t count = 0;
};

struct Corners {
    std::vector<Corner> corners;
    std::vector<std::uint32_t> indices;   ///< three per triangle
    std::vector<Batch> batches;           ///< in drawing order: opaque ones first, what hides most before what it hides
};

Corners make_corners(const model::FaceModel& model);

/// Centre and radius of the sphere nearest to some points (least squares of |x|^2 = 2 x.c + r^2 - c^2).
struct Sphere {
    Vec3 centre = Vec3::Zero();
    float radius = 1;
};
Sphere fit_sphere(PointsRef points, const std::vector<std::uint32_t>& rows);

}  // namespace mien::render
