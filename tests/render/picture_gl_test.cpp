#include <cmath>

#include "gl_test.hpp"
#include "media/colour.hpp"
#include "render/face_renderer.hpp"
#include "render/still.hpp"
#include "test_models.hpp"

namespace mien::render {
namespace {

using PictureGLTest = GLTest;

/// Looks straight at a card of 100 mm so that it fills a square picture exactly.
Camera card_camera() {
    Camera camera;
    camera.eye = Vec3(0, 0, 50 / std::tan(0.2f));
    camera.fov = 0.4f;
    camera.near = 1;
    camera.far = 1000;
    return camera;
}

Look flat_look() {
    Look look;
    look.lighting = Lighting::ambient_only();
    return look;
}

Image card_picture(const Image& texture, int side, const Look& look) {
    model::FaceModel model;
    model.neutral = make_card(100);
    FaceRenderer renderer(model);
    renderer.set_texture(texture);
    Target target(side, side, Smoothing::none);
    renderer.draw(card_camera(), look, target);
    return target.read();
}

int worst_difference(const Image& a, const Image& b) {
    EXPECT_EQ(a.pixels.size(), b.pixels.size());
    int worst = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) worst = std::max(worst, std::abs(int(a.pixels[i]) - int(b.pixels[i])));
    return worst;
}

TEST_F(PictureGLTest, AFlatAlbedoUnderAmbientLightComesOutAsItWentIn) {
    // Below the shoulder of 0.8 linear: 230 encoded.
    for (const int value : {0, 1, 5, 20, 64, 128, 200, 230}) {
        Image texture(4, 4, 3);
        for (std::size_t i = 0; i < texture.pixels.size(); i += 3) {
            texture.pixels[i] = std::uint8_t(value);
            texture.pixels[i + 1] = std::uint8_t(value / 2);
            texture.pixels[i + 2] = std::uint8_t(value / 4);
        }
        const Image picture = card_picture(texture, 16, flat_look());
        const std::uint8_t* middle = picture.at(8, 8);
        EXPECT_NEAR(middle[0], value, 1);
        EXPECT_NEAR(middle[1], value / 2, 1);
        EXPECT_NEAR(middle[2], value / 4, 1);
    }
}

TEST_F(PictureGLTest, ATextureStandsUprightAndUnmirrored) {
    Image texture(64, 64, 3);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            texture.at(x, y)[0] = x < 32 ? 200 : 10;
            texture.at(x, y)[1] = y < 32 ? 200 : 10;
        }
    const Image picture = card_picture(texture, 64, flat_look());
    EXPECT_LE(worst_difference(picture, texture), 1);
}

TEST_F(PictureGLTest, VideoPlanesGiveWhatTheDecodersOwnConversionGives) {
    Image texture(64, 64, 3);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            texture.at(x, y)[0] = std::uint8_t(40 + 3 * x);
            texture.at(x, y)[1] = std::uint8_t(220 - 2 * y - x);
            texture.at(x, y)[2] = std::uint8_t(60 + x + y);
        }
    for (const bool full_range : {false, true})
        for (const auto matrix : {YuvView::Matrix::bt709, YuvView::Matrix::bt601})
            for (const auto siting : {YuvView::Siting::left, YuvView::Siting::centre, YuvView::Siting::top_left}) {
                media::YuvImage planes(64, 64, media::Chroma::quarter);
                media::to_yuv(texture, planes);
                YuvView view = planes.view();
                view.full_range = full_range;
                view.matrix = matrix;
                view.siting = siting;
                model::FaceModel model;
                model.neutral = make_card(100);
                FaceRenderer renderer(model);
                renderer.set_texture(view);
                Target target(64, 64, Smoothing::none);
                Look look;
                look.lit = false;
                renderer.draw(card_camera(), look, target);
                // A GPU mixes samples with weights of eight bits, and the matrix nearly doubles what is lost.
                EXPECT_LE(worst_difference(target.read(), media::to_rgb(view)), 3)
                    << "range " << full_range << " matrix " << int(matrix) << " siting " << int(siting);
            }
}

TEST_F(PictureGLTest, OddSizedVideoKeepsItsPlace) {
    Image texture(51, 37, 3);
    for (int y = 0; y < 37; ++y)
        for (int x = 0; x < 51; ++x)
            for (int c = 0; c < 3; ++c) texture.at(x, y)[c] = std::uint8_t(30 + 2 * x + (c + 1) * y);
    media::YuvImage planes(52, 38, media::Chroma::quarter);   // coded even, shown odd
    media::to_yuv(texture, planes);
    YuvView view = planes.view();
    view.width = 51;
    view.height = 37;
    model::FaceModel model;
    model.neutral = make_card(100);
    model.neutral.positions.col(0) *= 51 / 37.0f;
    FaceRenderer renderer(model);
    renderer.set_texture(view);
    Target target(51, 37, Smoothing::none);
    Look look;
    look.lit = false;
    renderer.draw(card_camera(), look, target);
    EXPECT_LE(worst_difference(target.read(), media::to_rgb(view)), 3);
}

TEST_F(PictureGLTest, TheSamePictureComesTwice) {
    const auto draw = [] {
        model::FaceModel model;
        model.neutral = make_ball(90);
        FaceRenderer renderer(model);
        Target target(96, 108, Smoothing::edges);
        renderer.draw(frame_box(bounding_box(model.neutral.positions), 96 / 108.0f).camera(), {}, target);
        return target.read();
    };
    EXPECT_EQ(draw().pixels, draw().pixels);
}

TEST_F(PictureGLTest, FormedAndUploadedShapesLookTheSame) {
    model::FaceModel model;
    model.neutral = make_ball(90);
    const model::LinearMotion motion = random_motion(3 * model.point_count(), 8, 7);
    model::Motion instant;
    instant.coefficients = Eigen::VectorXf::LinSpaced(8, -8, 8);
    FaceRenderer formed(model, motion), uploaded(model);
    formed.set_motion(instant);
    uploaded.set_positions(model::evaluate(model, motion, instant));
    const Camera camera = frame_box(bounding_box(model.neutral.positions), 1).camera();
    Target target(128, 128, Smoothing::none);
    formed.draw(camera, {}, target);
    const Image a = target.read();
    uploaded.draw(camera, {}, target);
    const Image b = target.read();
    // Positions differ in their last bits, so a pixel of an outline may fall to the other side.
    int different = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) different += std::abs(int(a.pixels[i]) - int(b.pixels[i])) > 3;
    EXPECT_LE(different, 12);
}

TEST_F(PictureGLTest, TheKeyLightCastsAShadow) {
    // A small card in front of a large one, on the way to the key light.
    Mesh cards = make_card(200);
    const Mesh small = make_card(40);
    const Vec3 towards = Lighting::studio().lights[0].towards;
    cards.positions.conservativeResize(8, 3);
    cards.positions.bottomRows(4) = small.positions.rowwise() + 60 * towards.transpose();
    cards.triangles.insert(cards.triangles.end(), {{4, 5, 6}, {4, 6, 7}});
    cards.texcoords.clear();
    cards.texcoord_triangles.clear();
    model::FaceModel model;
    model.neutral = cards;
    FaceRenderer renderer(model);
    Target target(64, 64, Smoothing::none);
    Camera camera = card_camera();
    Look look;
    // Off the middle of the shadow's place, beside the small card: straight below the card along the light.
    renderer.draw(camera, look, target);
    const int shadowed = target.read().at(32, 32)[0];
    look.shadows = false;
    renderer.draw(camera, look, target);
    const int lit = target.read().at(32, 32)[0];
    EXPECT_LT(shadowed, lit - 20);
}

TEST_F(PictureGLTest, ABustFadesIntoTheWallAtItsCut) {
    model::FaceModel model;
    model.neutral = make_bust(-190);
    FaceRenderer renderer(model);
    constexpr int kSide = 256;
    Target target(kSide, kSide, Smoothing::none);
    const Camera camera = frame_box(bounding_box(model.neutral.positions), 1).camera();
    const Eigen::Matrix4f project = camera.projection(1) * camera.view();
    const auto step_at_the_edge = [&](const Image& picture, float y) {   // between the board and the wall beside it
        const auto red = [&](float x) {
            const Eigen::Vector4f clip = project * Eigen::Vector4f(x, y, 0, 1);
            return int(picture.at(int((0.5f + 0.5f * clip.x() / clip.w()) * kSide), int((0.5f - 0.5f * clip.y() / clip.w()) * kSide))[0]);
        };
        return std::abs(red(76) - red(84));
    };
    Look look;
    renderer.draw(camera, look, target);
    const Image picture = target.read();
    EXPECT_LT(step_at_the_edge(picture, -187), 6);
    EXPECT_GT(step_at_the_edge(picture, -165), 12);
    EXPECT_GT(step_at_the_edge(picture, -120), 40);
    look.backdrop = false;
    renderer.draw(camera, look, target);
    EXPECT_GT(step_at_the_edge(target.read(), -187), 40) << "no wall, nothing to fade into";
}

TEST_F(PictureGLTest, MissingMarkersAreNotDrawn) {
    model::FaceModel model;
    model::PointBase base;
    base.markers.resize(3, 3);
    base.markers << -30, -20, 0, 30, -20, 0, 0, 30, 0;
    base.triangulation = {{0, 1, 2}};
    model.base = base;
    FaceRenderer renderer(model, random_motion(9, 1, 1));
    Target target(64, 64, Smoothing::none);
    Look look = flat_look();
    look.backdrop = false;
    look.steps.motion = false;
    const auto lit_pixels = [&](std::vector<std::uint8_t> presence) {
        model::Motion motion;
        motion.coefficients = Eigen::VectorXf::Zero(1);
        motion.presence = std::move(presence);
        renderer.set_motion(motion);
        renderer.draw(card_camera(), look, target);
        const Image picture = target.read();
        int count = 0;
        for (std::size_t i = 0; i < picture.pixels.size(); i += 3) count += picture.pixels[i] > 100;
        return count;
    };
    const int all = lit_pixels({}), two = lit_pixels({1, 0, 1}), none = lit_pixels({0, 0, 0});
    EXPECT_GT(all, two);
    EXPECT_GT(two, 0);
    EXPECT_EQ(none, 0);
}

TEST(StillRendererGLTest, DrawsWithAContextOfItsOwn) {
    try {
        StillRenderer still(make_ball(90));
        const Image picture = still.picture(frame_box(bounding_box(make_ball(90).positions), 1).camera(), 64, 64);
        EXPECT_EQ(picture.width, 64);
        EXPECT_GT(picture.at(32, 32)[0], picture.at(1, 1)[0] + 30) << "skin in the middle, backdrop in the corner";
    } catch (const EnvironmentError& error) {
        GTEST_SKIP() << "skipped: " << error.what();
    }
}

}  // namespace
}  // namespace mien::render
