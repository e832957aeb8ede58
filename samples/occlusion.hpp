#pragma once

#include <vector>

#include "core/geometry.hpp"
#include "core/mesh.hpp"

namespace mien::samples {

/// Ambient occlusion of a deforming mesh: how much of the sky each point sees, by drawing the mesh into a small depth
/// buffer along each of a fixed set of directions. Both ends of an axis come from one drawing.
class Occlusion {
public:
    /// blockers: triangles that cast shade. axes: directions / 2. resolution: depth cells per side.
    explicit Occlusion(std::vector<Triangle> blockers, int axes = 22, int resolution = 192);

    /// The cosine-weighted open part of the hemisphere above each point, 1 open .. 0 closed. positions, normals: V x 3
    /// (mm, unit); blockers index positions. `reach`: mm; a blocker this far
    /// off shades half as much as a touching one.
    Eigen::VectorXf at(PointsRef positions, PointsRef normals, float reach) const;

private:
    std::vector<Triangle> blockers_;
    std::vector<Vec3> axes_;
    int resolution_;
};

}  // namespace mien::samples
