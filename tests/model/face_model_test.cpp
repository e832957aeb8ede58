#include "model/face_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "meshes.hpp"

namespace mien::model {
namespace {

LinearMotion random_motion(Eigen::Index dimension, Eigen::Index k, unsigned seed) {
    std::srand(seed);
    return {Eigen::VectorXf::Random(dimension) * 3, Eigen::MatrixXf::Random(dimension, k)};
}

Motion instant(Eigen::Index k) {
    Motion motion;
    motion.coefficients = Eigen::VectorXf::LinSpaced(k, -2, 3);
    return motion;
}

FaceModel mesh_model() {
    FaceModel model;
    model.neutral = sheet(4);
    return model;
}

TEST(FaceModel, VertexMotionIsNeutralPlusOffsets) {
    const FaceModel model = mesh_model();
    const LinearMotion basis = random_motion(48, 5, 1);
    const Motion now = instant(5);
    const Points points = evaluate(model, compose(model, basis), now);
    const Eigen::VectorXf x = basis.mean + basis.components * now.coefficients;
    for (Eigen::Index v = 0; v < 16; ++v)
        EXPECT_LT((points.row(v) - model.neutral.positions.row(v) - x.segment<3>(3 * v).transpose()).norm(), 1e-5f);
}

TEST(FaceModel, BlendedVerticesMoveByTheirSharesOfTheMarkers) {
    FaceModel model = mesh_model();
    BlendBase base;
    base.sites = {Site::at_vertex(0), Site::at_vertex(5), Site::at_vertex(9)};
    base.markers.resize(3, 3);
    for (int m = 0; m < 3; ++m) base.markers.row(m) = base.sites[std::size_t(m)].position(model.neutral.positions).transpose();
    base.row_start.push_back(0);
    for (std::uint32_t v = 0; v < 16; ++v) {
        for (std::uint32_t m = 0; m < v % 4; ++m) base.terms.push_back({m, 0.1f * float(v % 3 + m + 1)});
        base.row_start.push_back(std::uint32_t(base.terms.size()));
    }
    model.base = base;
    const LinearMotion basis = random_motion(9, 4, 2);
    const Motion now = instant(4);
    const Points points = evaluate(model, compose(model, basis), now);
    const Eigen::VectorXf d = basis.mean + basis.components * now.coefficients;
    for (std::uint32_t v = 0; v < 16; ++v) {
        Vec3 want = model.neutral.positions.row(v).transpose();
        for (std::uint32_t m = 0; m < v % 4; ++m) want += 0.1f * float(v % 3 + m + 1) * d.segment<3>(3 * m);
        EXPECT_LT((points.row(v).transpose() - want).norm(), 1e-4f) << v;
    }
}

TEST(FaceModel, BlendshapesAddUpByWeight) {
    FaceModel model = mesh_model();
    BlendshapeBase base;
    for (int t = 0; t < 3; ++t) base.targets.push_back({"", Points::Random(16, 3) * 4});
    model.base = base;
    const LinearMotion basis = random_motion(3, 2, 3);
    const Motion now = instant(2);
    const Points points = evaluate(model, compose(model, basis), now);
    const Eigen::VectorXf w = basis.mean + basis.components * now.coefficients;
    Points want = model.neutral.positions;
    for (int t = 0; t < 3; ++t) want += w[t] * base.targets[std::size_t(t)].offsets;
    EXPECT_LT((points - want).cwiseAbs().maxCoeff(), 1e-4f);
}

TEST(FaceModel, WeightsWithoutARigLeaveTheNeutralFace) {
    FaceModel model = mesh_model();
    model.base = BlendshapeBase{};
    const Motion now = instant(2);
    EXPECT_EQ(evaluate(model, compose(model, random_motion(52, 2, 4)), now), model.neutral.positions);
}

TEST(FaceModel, MarkersAloneMoveByThemselves) {
    FaceModel model;
    PointBase base;
    base.markers = Points::Random(6, 3) * 50;
    model.base = base;
    EXPECT_EQ(model.point_count(), 6);
    const LinearMotion basis = random_motion(18, 3, 5);
    const Motion now = instant(3);
    const Points points = evaluate(model, compose(model, basis), now);
    const Eigen::VectorXf x = basis.mean + basis.components * now.coefficients;
    EXPECT_LT((points - base.markers - ConstPointsMap(x.data(), 6, 3)).cwiseAbs().maxCoeff(), 1e-4f);
}

TEST(FaceModel, GazeTurnsTheEyeAboutItsCentreToTheActorsLeftAndUp) {
    FaceModel model;
    model.neutral.positions.resize(6, 3);
    const Vec3 centre(-31, 4, 70);
    model.neutral.positions << -31, 4, 82, -19, 4, 70, -31, 16, 70, -31, 4, 82, 0, 0, 0, 31, 4, 82;
    model.eyes[0] = Eyeball{centre, {0, 1, 2}};
    model.eyes[1] = Eyeball{Vec3(31, 4, 70), {5}};
    const LinearMotion still{Eigen::VectorXf::Zero(18), Eigen::MatrixXf::Zero(18, 0)};
    Motion now = instant(0);
    now.gaze.yaw[0] = 0.3f;
    Points turned = evaluate(model, still, now);
    EXPECT_LT((turned.row(0).transpose() - centre - 12 * Vec3(std::sin(0.3f), 0, std::cos(0.3f))).norm(), 1e-4f) << "the pupil goes to +x";
    EXPECT_LT((turned.row(2) - model.neutral.positions.row(2)).norm(), 1e-4f) << "the pole stays";
    EXPECT_EQ(turned.bottomRows(3), model.neutral.positions.bottomRows(3)) << "not of this eye";
    now.gaze.yaw[0] = 0;
    now.gaze.pitch[0] = 0.2f;
    turned = evaluate(model, still, now);
    EXPECT_LT((turned.row(0).transpose() - centre - 12 * Vec3(0, std::sin(0.2f), std::cos(0.2f))).norm(), 1e-4f) << "the pupil goes up";
    EXPECT_LT((turned.row(1) - model.neutral.positions.row(1)).norm(), 1e-4f) << "the side stays";
    now.gaze.yaw[0] = 0.4f;
    turned = evaluate(model, still, now);
    for (int v = 0; v < 3; ++v) EXPECT_NEAR((turned.row(v).transpose() - centre).norm(), 12, 1e-4f);
    EXPECT_NEAR(turned(0, 1) - centre.y(), 12 * std::sin(0.2f), 1e-4f) << "pitch is kept whatever the yaw";
}

TEST(FaceModel, TheHeadPoseComesLast) {
    FaceModel model = mesh_model();
    model.eyes[0] = Eyeball{Vec3(1, 2, -10), {3, 4, 5}};
    const LinearMotion basis = random_motion(48, 2, 6);
    Motion now = instant(2);
    now.gaze.yaw[0] = 0.5f;
    const Points unposed = evaluate(model, basis, now);
    now.pose.rotation = Eigen::Quaternionf(Eigen::AngleAxisf(0.7f, Vec3(1, 2, 3).normalized()));
    now.pose.translation = Vec3(10, -4, 300);
    const Points posed = evaluate(model, basis, now);
    for (Eigen::Index v = 0; v < posed.rows(); ++v)
        EXPECT_LT((posed.row(v).transpose() - now.pose.apply(unposed.row(v).transpose())).norm(), 1e-3f);
}

}  // namespace
}  // namespace mien::model
