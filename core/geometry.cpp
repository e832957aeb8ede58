#include "core/geometry.hpp"

#include <Eigen/SVD>

namespace mien {

void apply_pose(const RigidPose& pose, Eigen::Ref<Points> points) {
    const Eigen::Matrix3f rotation = pose.rotation.toRotationMatrix();
    points = (points * rotation.transpose()).eval();
    points.rowwise() += pose.translation.transpose();
}

RigidPose fit_rigid(PointsRef from, PointsRef to, const Eigen::Ref<const Eigen::VectorXf>& weights) {
    eigen_assert(from.rows() == to.rows() && (weights.size() == 0 || weights.size() == from.rows()));
    using Vec3d = Eigen::Vector3d;
    double total = 0;
    Vec3d centre_from = Vec3d::Zero(), centre_to = Vec3d::Zero();
    const auto weight = [&](Eigen::Index i) { return weights.size() ? double(weights[i]) : 1.0; };
    for (Eigen::Index i = 0; i < from.rows(); ++i) {
        total += weight(i);
        centre_from += weight(i) * from.row(i).transpose().cast<double>();
        centre_to += weight(i) * to.row(i).transpose().cast<double>();
    }
    if (total <= 0) return {};
    centre_from /= total;
    centre_to /= total;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < from.rows(); ++i)
        covariance += weight(i) * (to.row(i).transpose().cast<double>() - centre_to) *
                      (from.row(i).transpose().cast<double>() - centre_from).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    if (svd.singularValues()[1] > 1e-9 * std::max(svd.singularValues()[0], 1e-30)) {
        // The smallest direction carries the sign, so the result is a rotation and never a mirror.
        const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
        rotation = svd.matrixU() * Vec3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    }
    RigidPose pose;
    pose.rotation = Eigen::Quaterniond(rotation).normalized().cast<float>();
    pose.translation = (centre_to - rotation * centre_from).cast<float>();
    return pose;
}

}  // namespace mien
