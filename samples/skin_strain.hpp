#pragma once

#include <vector>

#include "core/mesh.hpp"

namespace mien::samples {

/// How skin is stretched and squeezed against the neutral mesh, per vertex. Triangles of other surfaces count
/// nothing.
class Strain {
public:
    /// passes: of smoothing over neighbours, because blood spreads wider than a triangle.
    explicit Strain(const Mesh& neutral, int passes = 6);

    struct Field {
        Eigen::VectorXf growth;   ///< V, log of deformed area / neutral area
        Eigen::VectorXf squeeze;  ///< V, -log of the smaller principal stretch, at least 0
    };
    Field at(PointsRef deformed) const;

private:
    struct Rest {
        Triangle corners;
        Eigen::Matrix2f edges_inverse;  // neutral edges in the triangle's own plane
        float area;
    };
    std::vector<Rest> rest_;
    std::vector<float> area_;  // V, of the triangles around
    std::vector<std::uint32_t> begin_,
        around_;  // neighbours of v: around_[begin_[v]] .. around_[begin_[v + 1]]
    int passes_;
};

}  // namespace mien::samples
