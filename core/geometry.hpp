#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mien {

using Vec2 = Eigen::Vector2f;
using Vec3 = Eigen::Vector3f;

/// N x 3 positions or offsets, x y z interleaved in memory (row-major), millimetres unless said otherwise.
using Points = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
using PointsMap = Eigen::Map<Points>;
using ConstPointsMap = Eigen::Map<const Points>;
using PointsRef = Eigen::Ref<const Points>;

/// A rigid motion from head space to the clip's space: x -> rotation * x + translation (mm).
struct RigidPose {
    Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
    Vec3 translation = Vec3::Zero();

    Vec3 apply(const Vec3& x) const { return rotation * x + translation; }
    RigidPose inverse() const {
        const Eigen::Quaternionf back = rotation.conjugate();
        return {back, -(back * translation)};
    }
};

/// Turns every row of `points` by `pose`, in place.
void apply_pose(const RigidPose& pose, Eigen::Ref<Points> points);

/// argmin over rigid motions of sum_i w_i |R from_i + t - to_i|^2 (Kabsch 1976; Umeyama without scale), in double inside.
/// from, to: N x 3; weights: N, or empty for all one. With fewer than three points of positive weight that are not on
/// a line the free rotations stay at identity.
RigidPose fit_rigid(PointsRef from, PointsRef to, const Eigen::Ref<const Eigen::VectorXf>& weights = Eigen::VectorXf());

/// Where the eyes look: radians in head space, yaw > 0 to +x (the actor's left), pitch > 0 up. Index 0: the actor's right eye.
struct Gaze {
    float yaw[2] = {0, 0};
    float pitch[2] = {0, 0};
};

/// A point on a mesh: the mixture of up to three vertices. A plain vertex is {{v, v, v}, {1, 0, 0}}.
struct Site {
    std::uint32_t vertices[3] = {0, 0, 0};
    float weights[3] = {1, 0, 0};

    static Site at_vertex(std::uint32_t v) { return {{v, v, v}, {1, 0, 0}}; }
    Vec3 position(PointsRef points) const {
        return weights[0] * points.row(vertices[0]).transpose() + weights[1] * points.row(vertices[1]).transpose() +
               weights[2] * points.row(vertices[2]).transpose();
    }
};

}  // namespace mien
