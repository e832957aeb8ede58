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

TEST(PixelsOf, HoldWhateverTheCameraShowsOfABox) {
    const Eigen::AlignedBox3f box(Vec3(-50, -20, -30), Vec3(10, 90, 40));
    RigidPose pose;
    pose.translation = Vec3(5, -8, 12);
    pose.rotation = Eigen::AngleAxisf(0.4f, Vec3(0.3f, 1, 0.2f).normalized());
    Camera camera;
    camera.eye = Vec3(100, 50, 500);
    constexpr int kWidth = 320, kHeight = 200;
    const Eigen::AlignedBox2i pixels = pixels_of(box, pose, camera, kWidth, kHeight);
    const Eigen::Matrix4f project = camera.projection(float(kWidth) / kHeight) * camera.view();
    for (int i = 0; i < 1000; ++i) {
        const Vec3 share((i % 10) / 9.0f, (i / 10 % 10) / 9.0f, (i / 100) / 9.0f);
        const Vec3 inside = box.min() + share.cwiseProduct(box.sizes());
        const Eigen::Vector4f clip = project * pose.apply(inside).homogeneous();
        const float x = (clip.x() / clip.w() * 0.5f + 0.5f) * kWidth, y = (clip.y() / clip.w() * 0.5f + 0.5f) * kHeight;
        ASSERT_TRUE(x >= pixels.min().x() && x <= pixels.max().x() && y >= pixels.min().y() && y <= pixels.max().y()) << x << ' ' << y;
    }
    EXPECT_LT(pixels.sizes().prod(), kWidth * kHeight / 3) << "and not much more";

    camera.eye = Vec3(0, 0, 30);   // among it
    EXPECT_EQ(pixels_of(box, {}, camera, kWidth, kHeight).sizes(), Eigen::Vector2i(kWidth, kHeight));
    camera.eye = Vec3(0, 5000, 500), camera.target = Vec3(0, 5000, 0);   // looking past it
    EXPECT_TRUE(pixels_of(box, {}, camera, kWidth, kHeight).isEmpty() || pixels_of(box, {}, camera, kWidth, kHeight).volume() == 0);
}

}  // namespace
}  // namespace mien::render
