#include "render/camera.hpp"

#include <gtest/gtest.h>

#include "render/corners.hpp"
#include "test_models.hpp"

namespace mien::render {
namespace {

Eigen::Vector2f in_picture(const Camera& camera, float aspect, const Vec3& point) {
    const Eigen::Vector4f clip = camera.projection(aspect) * camera.view() * point.homogeneous();
    return clip.head<2>() / clip.w();
}

const Eigen::AlignedBox3f kHead(Vec3(-80, -150, -100), Vec3(80, 130, 110));

TEST(Camera, ShowsUpAsUpAndTheActorsLeftAtTheRight) {
    const Camera camera = frame_box(kHead, 8 / 9.0f).camera();
    EXPECT_GT(in_picture(camera, 1, kHead.center() + Vec3(0, 50, 0)).y(), 0.05f);
    EXPECT_GT(in_picture(camera, 1, kHead.center() + Vec3(50, 0, 0)).x(), 0.05f);
    EXPECT_LT(in_picture(camera, 1, kHead.center()).norm(), 1e-4f);
}

TEST(Camera, FramesTheWholeBoxFromEverySide) {
    for (const float aspect : {0.5f, 8 / 9.0f, 16 / 9.0f})
        for (const View view : {View::front, View::left, View::right}) {
            const Camera camera = frame_box(kHead, aspect, view).camera();
            float reach = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const Vec3 at = kHead.corner(Eigen::AlignedBox3f::CornerType(corner));
                // A head is round: its box's corners are air.
                const Vec3 on_head = kHead.center() + 0.8f * (at - kHead.center());
                reach = std::max(reach, in_picture(camera, aspect, on_head).cwiseAbs().maxCoeff());
            }
            EXPECT_LT(reach, 1.0f);
            EXPECT_GT(reach, 0.5f) << "but not lost in the middle";
        }
}

TEST(Camera, LeftShowsTheActorsLeftSide) {
    EXPECT_GT(frame_box(kHead, 1, View::left).camera().eye.x(), 100);
    EXPECT_LT(frame_box(kHead, 1, View::right).camera().eye.x(), -100);
    EXPECT_EQ(parse_view("left"), View::left);
    EXPECT_EQ(parse_view("behind"), std::nullopt);
}

TEST(Camera, PanMovesThePictureWithTheMouse) {
    OrbitCamera orbit = frame_box(kHead, 1, View::left);
    orbit.pan = Vec2(20, 10);
    const Eigen::Vector2f centre = in_picture(orbit.camera(), 1, kHead.center());
    EXPECT_GT(centre.x(), 0.01f);
    EXPECT_GT(centre.y(), 0.01f);
}

TEST(Camera, OrbitStopsShortOfThePoles) {
    OrbitCamera orbit = frame_box(kHead, 1);
    orbit.orbit(0, 10);
    EXPECT_LT(orbit.pitch, 1.55f);
    EXPECT_TRUE(orbit.camera().view().allFinite());
}

TEST(Camera, ABoxOfNothingStillGivesACamera) {
    const Points none(0, 3);
    EXPECT_TRUE(frame_box(bounding_box(none), 1).camera().view().allFinite());
}

TEST(FitSphere, FindsTheEyeballOfAVisibleCap) {
    const Mesh ball = make_ball(12);
    std::vector<std::uint32_t> cap;
    Points moved = ball.positions.rowwise() + Eigen::RowVector3f(31, 22, 60);
    for (std::uint32_t v = 0; v < ball.vertex_count(); ++v)
        if (ball.positions(v, 2) > 7) cap.push_back(v);
    const Sphere sphere = fit_sphere(moved, cap);
    EXPECT_LT((sphere.centre - Vec3(31, 22, 60)).norm(), 0.01f);
    EXPECT_NEAR(sphere.radius, 12, 0.01f);
}

TEST(Corners, ASeamSplitsItsVerticesAndNothingElse) {
    model::FaceModel model;
    model.neutral = make_card(10);
    model.neutral.texcoords.emplace_back(0.5f, 0.5f);
    model.neutral.texcoord_triangles[1] = {4, 2, 3};   // vertex 0 has two texture coordinates
    const Corners corners = make_corners(model);
    EXPECT_EQ(corners.corners.size(), 5u);
    ASSERT_EQ(corners.indices.size(), 6u);
    EXPECT_EQ(corners.corners[corners.indices[0]].vertex, 0u);
    EXPECT_EQ(corners.corners[corners.indices[3]].vertex, 0u);
    EXPECT_NE(corners.indices[0], corners.indices[3]);
}

TEST(Corners, PartsOutsideThePictureAreNotTextured) {
    model::FaceModel model;
    model.neutral = make_card(10);
    model.neutral.parts = {{"skin", Surface::skin, 0, 1}, {"teeth", Surface::teeth, 1, 1}};
    for (Vec2& uv : model.neutral.texcoords) uv.x() += uv.y() > 0.5f && uv.x() < 0.5f ? 3.0f : 0.0f;
    const Corners corners = make_corners(model);
    ASSERT_EQ(corners.batches.size(), 2u);
    EXPECT_TRUE(corners.batches[0].textured);
    EXPECT_FALSE(corners.batches[1].textured);
}

}  // namespace
}  // namespace mien::render
