#include "model/face_model.hpp"

#include <cassert>

namespace mien::model {
namespace {

/// D (3V x k) from C (3M x k): row block j of D = sum over the terms of vertex j of a_jk times row block k of C.
Eigen::MatrixXf blend_rows(const BlendBase& base, const Eigen::MatrixXf& markers) {
    const Eigen::Index V = Eigen::Index(base.row_start.size()) - 1;
    Eigen::MatrixXf vertices = Eigen::MatrixXf::Zero(3 * V, markers.cols());
    for (Eigen::Index column = 0; column < markers.cols(); ++column)
        for (Eigen::Index j = 0; j < V; ++j)
            for (std::uint32_t i = base.row_start[j]; i < base.row_start[j + 1]; ++i) {
                const BlendBase::Term& term = base.terms[i];
                vertices.col(column).segment<3>(3 * j) +=
                    term.weight * markers.col(column).segment<3>(3 * Eigen::Index(term.marker));
            }
    return vertices;
}

/// The same through a dense V x M response.
Eigen::MatrixXf shell_rows(const ShellBase& base, const Eigen::MatrixXf& markers) {
    using RowPoints = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Eigen::Index V = base.response.rows(), M = base.response.cols();
    Eigen::MatrixXf vertices(3 * V, markers.cols());
    for (Eigen::Index column = 0; column < markers.cols(); ++column)
        Eigen::Map<RowPoints>(vertices.col(column).data(), V, 3).noalias() = base.response * Eigen::Map<const RowPoints>(markers.col(column).data(), M, 3);
    return vertices;
}

Eigen::MatrixXf blendshape_rows(const BlendshapeBase& base, Eigen::Index rows, const Eigen::MatrixXf& weights) {
    if (base.targets.empty()) return Eigen::MatrixXf::Zero(rows, weights.cols());  // weights without a rig move nothing
    assert(Eigen::Index(base.targets.size()) == weights.rows());
    Eigen::MatrixXf targets(rows, Eigen::Index(base.targets.size()));
    for (Eigen::Index i = 0; i < targets.cols(); ++i)
        targets.col(i) = Eigen::Map<const Eigen::VectorXf>(base.targets[i].offsets.data(), rows);
    return targets * weights;
}

void turn_eye(const Eyeball& eye, float yaw, float pitch, Points& points) {
    // Yaw > 0 looks to +x, pitch > 0 looks up; +z is straight ahead.
    const Eigen::Matrix3f turn = (Eigen::AngleAxisf(yaw, Vec3::UnitY()) * Eigen::AngleAxisf(-pitch, Vec3::UnitX())).toRotationMatrix();
    for (const std::uint32_t v : eye.vertices) {
        const Vec3 arm = points.row(v).transpose() - eye.centre;
        points.row(v) = (eye.centre + turn * arm).transpose();
    }
}

}  // namespace

Eigen::Index FaceModel::point_count() const { return neutral_points(*this).rows(); }

const Points& neutral_points(const FaceModel& model) {
    const auto* points = std::get_if<PointBase>(&model.base);
    return points ? points->markers : model.neutral.positions;
}

const Points* driving_markers(const FaceModel& model) {
    if (const auto* blend = std::get_if<BlendBase>(&model.base)) return &blend->markers;
    if (const auto* shell = std::get_if<ShellBase>(&model.base)) return &shell->markers;
    if (const auto* points = std::get_if<PointBase>(&model.base)) return &points->markers;
    return nullptr;
}

const std::vector<Site>* driving_sites(const FaceModel& model) {
    if (const auto* blend = std::get_if<BlendBase>(&model.base)) return &blend->sites;
    if (const auto* shell = std::get_if<ShellBase>(&model.base)) return &shell->sites;
    return nullptr;
}

LinearMotion compose(const FaceModel& model, const LinearMotion& motion) {
    const auto through = [&](const auto& rows) {
        return LinearMotion{rows(Eigen::MatrixXf(motion.mean)), rows(motion.components)};
    };
    if (const auto* blend = std::get_if<BlendBase>(&model.base)) {
        assert(motion.dimension() == 3 * blend->markers.rows());
        return through([&](const Eigen::MatrixXf& m) { return blend_rows(*blend, m); });
    }
    if (const auto* shell = std::get_if<ShellBase>(&model.base)) {
        assert(motion.dimension() == 3 * shell->response.cols());
        return through([&](const Eigen::MatrixXf& m) { return shell_rows(*shell, m); });
    }
    if (const auto* shapes = std::get_if<BlendshapeBase>(&model.base))
        return through([&](const Eigen::MatrixXf& m) { return blendshape_rows(*shapes, model.neutral.positions.size(), m); });
    assert(motion.dimension() == 3 * model.point_count());
    return motion;
}

Points evaluate(const FaceModel& model, const LinearMotion& composed, const Motion& motion) {
    const Eigen::VectorXf offsets = composed.mean + composed.components * motion.coefficients;
    Points points = neutral_points(model) + ConstPointsMap(offsets.data(), offsets.size() / 3, 3);
    if (model.detail) model.detail->add_medium(model.detail->parameters(points), points);
    for (int side = 0; side < 2; ++side)
        if (model.eyes[side]) turn_eye(*model.eyes[side], motion.gaze.yaw[side], motion.gaze.pitch[side], points);
    if (model.contact) hold_apart(*model.contact, points);
    apply_pose(motion.pose, points);
    return points;
}

}  // namespace mien::model
