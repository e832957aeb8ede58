#include "coding/motion_values.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace mien::coding {

Eigen::VectorXf mean_of(const MotionBasis& basis) {
    Eigen::VectorXf mean(Eigen::Index(basis.mean.size()));
    for (std::size_t i = 0; i < basis.mean.size(); ++i) mean[Eigen::Index(i)] = float(basis.mean[i]) * basis.mean_step;
    return mean;
}

double length_of(std::span<const std::int32_t> vector) {
    // |v| < 2^28 and at most 2^26 values: squares sum up to below 2^82, so halves are kept apart in doubles' exact range.
    double sum = 0;
    for (std::int32_t v : vector) sum += double(v) * double(v);
    return std::sqrt(sum);
}

std::vector<double> component_scales(const MotionBasis& basis) {
    std::vector<double> scales;
    for (const auto& vector : basis.components) {
        const double length = length_of(vector);
        scales.push_back(length > 0 ? double(basis.step) / MotionBasis::kFraction / length : 0);
    }
    return scales;
}

Eigen::MatrixXf components_of(const MotionBasis& basis) {
    Eigen::MatrixXf columns(Eigen::Index(basis.mean.size()), Eigen::Index(basis.size()));
    const std::vector<double> scales = component_scales(basis);
    for (std::size_t j = 0; j < basis.components.size(); ++j) {
        const auto& vector = basis.components[j];
        float* column = columns.data() + j * vector.size();
        for (std::size_t i = 0; i < vector.size(); ++i) column[i] = float(double(vector[i]) * scales[j]);
    }
    return columns;
}

std::array<double, 6> pose_steps(const MotionBasis& basis, const RigidPose& pose) {
    const Eigen::Vector3d centre(basis.centre[0], basis.centre[1], basis.centre[2]);
    const Eigen::Quaterniond rotation = pose.rotation.cast<double>();
    const Eigen::Vector3d shift = rotation * centre + pose.translation.cast<double>() - centre;
    const Eigen::AngleAxisd turn(rotation);
    double angle = turn.angle();
    if (angle > 3.14159265358979) angle -= 2 * 3.14159265358979323846;
    const Eigen::Vector3d vector = angle * turn.axis();
    std::array<double, 6> steps{};
    for (std::size_t i = 0; i < 3; ++i) {
        steps[i] = shift[Eigen::Index(i)] / basis.translation_step;
        steps[3 + i] = vector[Eigen::Index(i)] / basis.rotation_step;
    }
    return steps;
}

std::array<double, 4> gaze_steps(const MotionBasis& basis, const Gaze& gaze) {
    return {gaze.yaw[0] / double(basis.gaze_step), gaze.pitch[0] / double(basis.gaze_step),
            gaze.yaw[1] / double(basis.gaze_step), gaze.pitch[1] / double(basis.gaze_step)};
}

RigidPose pose_of(const MotionBasis& basis, const std::array<std::int64_t, 6>& samples) {
    const auto value = [&](std::size_t i, float step) {
        return (double(samples[i]) / MotionBasis::kFraction + basis.side_mean[i]) * double(step);
    };
    const Eigen::Vector3d centre(basis.centre[0], basis.centre[1], basis.centre[2]);
    const Eigen::Vector3d shift(value(0, basis.translation_step), value(1, basis.translation_step),
                                value(2, basis.translation_step));
    const Eigen::Vector3d vector(value(3, basis.rotation_step), value(4, basis.rotation_step),
                                 value(5, basis.rotation_step));
    const double angle = vector.norm();
    const Eigen::Quaterniond rotation =
        angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(std::fmod(angle, 2 * 3.14159265358979323846), vector / angle))
                  : Eigen::Quaterniond::Identity();
    RigidPose pose;
    pose.rotation = rotation.cast<float>();
    pose.translation = (centre + shift - rotation * centre).cast<float>();
    return pose;
}

Gaze gaze_of(const MotionBasis& basis, const MotionShape& shape, const std::array<std::int64_t, 4>& samples) {
    const std::size_t first = shape.pose ? 6 : 0;
    std::array<float, 4> value{};
    for (std::size_t i = 0; i < 4; ++i)
        value[i] = float((double(samples[i]) / MotionBasis::kFraction + basis.side_mean[first + i]) * double(basis.gaze_step));
    return {{value[0], value[2]}, {value[1], value[3]}};
}

}  // namespace mien::coding
