#pragma once

#include <vector>

#include "core/geometry.hpp"
#include "core/mesh.hpp"

namespace mien::samples {

/// Ambient occlusion of a deforming mesh: how much of the sky each point sees, by drawing the mesh into a
/// small depth buffer along each of a fixed set of directions. Both ends of an axis come from one drawing.
class Occlusion {
public:
    /// rest: V x 3, mm, from which the depth buffers take their place; it stays the same in every frame, so
    /// that what does not move does not flicker. blockers: triangles that cast shade. axes: directions / 2.
    /// resolution: depth cells per side.
    Occlusion(PointsRef rest, std::vector<Triangle> blockers, int axes = 22, int resolution = 192);

    /// The cosine-weighted open part of the hemisphere above each point, 1 open .. 0 closed. positions,
    /// normals: V x 3 (mm, unit). `reach`: mm; a blocker this far off shades half as much as a touching one.
    Eigen::VectorXf at(PointsRef positions, PointsRef normals, float reach) const;

private:
    struct View {  // along one axis: x, y in cells, z in mm
        Vec3 side, up, axis;
        float x_low, y_low, cell;
    };
    std::vector<Triangle> blockers_;
    std::vector<View> views_;
    int resolution_;
};

}  // namespace mien::samples
