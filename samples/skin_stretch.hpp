#pragma once

#include <vector>

#include "core/mesh.hpp"

namespace mien::samples {

/// The whole strain of skin against the neutral mesh, per vertex: the logarithm of the right stretch tensor (Hencky strain),
/// a symmetric 3 x 3 matrix that acts in the neutral surface's tangent plane. Along a unit tangent a, a' H a is about the
/// logarithm of the stretch that way; its trace is the logarithm of the change in area.
class Stretch {
public:
    /// passes: of smoothing over neighbours.
    explicit Stretch(const Mesh& neutral, int passes = 2);

    /// xx yy zz xy xz yz of H, V rows; zero where there is no skin.
    using Field = Eigen::Matrix<float, Eigen::Dynamic, 6, Eigen::RowMajor>;
    Field at(PointsRef deformed) const;

private:
    struct Rest {
        Triangle corners;
        Vec3 x, y;                      // unit tangents of the neutral triangle
        Eigen::Matrix2f edges_inverse;  // of its neutral edges in x, y
        float area;
    };
    std::vector<Rest> rest_;
    std::vector<float> area_;
    std::vector<std::uint32_t> begin_, around_;  // neighbours of v: around_[begin_[v]] .. around_[begin_[v + 1]]
    int passes_;
};

/// a' H a of one row of a field.
inline float along(const float* h, const Vec3& a) {
    return a.x() * a.x() * h[0] + a.y() * a.y() * h[1] + a.z() * a.z() * h[2] +
           2 * (a.x() * a.y() * h[3] + a.x() * a.z() * h[4] + a.y() * a.z() * h[5]);
}
/// H v.
inline Vec3 times(const float* h, const Vec3& v) {
    return {h[0] * v.x() + h[3] * v.y() + h[4] * v.z(), h[3] * v.x() + h[1] * v.y() + h[5] * v.z(),
            h[4] * v.x() + h[5] * v.y() + h[2] * v.z()};
}

}  // namespace mien::samples
