#include <cmath>

#include "render/face_renderer.hpp"
#include "gl_test.hpp"
#include "test_models.hpp"

namespace mien::render {
namespace {

using ShapeGLTest = GLTest;

model::FaceModel ball_with_eyes() {
    model::FaceModel model;
    model.neutral = make_ball(90);
    model::Eyeball eye;
    eye.centre = Vec3(-30, 20, 70);
    for (std::uint32_t v = 100; v < 160; ++v) eye.vertices.push_back(v);
    model.eyes[0] = eye;
    eye.centre = Vec3(30, 20, 70);
    for (std::uint32_t& v : eye.vertices) v += 200;
    model.eyes[1] = eye;
    return model;
}

model::Motion some_motion(Eigen::Index k) {
    model::Motion motion;
    motion.coefficients = Eigen::VectorXf::LinSpaced(k, -40, 60);
    motion.pose.rotation = Eigen::AngleAxisf(0.4f, Vec3(0.3f, 1, -0.2f).normalized());
    motion.pose.translation = Vec3(12, -30, 400);
    motion.gaze = {{0.3f, -0.2f}, {0.1f, -0.25f}};
    return motion;
}

void expect_points_near(const Points& got, const Points& truth, float tolerance) {
    ASSERT_EQ(got.rows(), truth.rows());
    EXPECT_LE((got - truth).rowwise().norm().maxCoeff(), tolerance);
}

void draw_once(FaceRenderer& renderer, const Look& look = {}) {
    Target target(32, 32, Smoothing::none);
    renderer.draw(Camera{}, look, target);
}

TEST_F(ShapeGLTest, TheGpuFormsWhatEvaluateForms) {
    const model::FaceModel model = ball_with_eyes();
    const model::LinearMotion motion = random_motion(3 * model.point_count(), 37, 1);
    FaceRenderer renderer(model, motion);
    const model::Motion instant = some_motion(37);
    renderer.set_motion(instant);
    draw_once(renderer);
    const Points truth = model::evaluate(model, motion, instant);
    expect_points_near(renderer.read_positions(), truth, 1e-3f);
    expect_points_near(renderer.read_normals(), vertex_normals(truth, model.neutral.triangles), 2e-4f);
}

TEST_F(ShapeGLTest, ASecondInstantLeavesNothingOfTheFirst) {
    const model::FaceModel model = ball_with_eyes();
    const model::LinearMotion motion = random_motion(3 * model.point_count(), 5, 2);
    FaceRenderer renderer(model, motion);
    renderer.set_motion(some_motion(5));
    draw_once(renderer);
    model::Motion second;
    second.coefficients = Eigen::VectorXf::Ones(5);
    renderer.set_motion(second);
    draw_once(renderer);
    expect_points_near(renderer.read_positions(), model::evaluate(model, motion, second), 1e-3f);
}

TEST_F(ShapeGLTest, BlendBasesAreFormedThroughTheirComposedBasis) {
    model::FaceModel model;
    model.neutral = make_card(100);
    model::BlendBase blend;
    blend.markers = model.neutral.positions.topRows(2);
    blend.sites = {Site::at_vertex(0), Site::at_vertex(1)};
    blend.row_start = {0, 1, 2, 4, 4};
    blend.terms = {{0, 1.0f}, {1, 1.0f}, {0, 0.4f}, {1, 0.6f}};
    model.base = blend;
    const model::LinearMotion markers = random_motion(6, 4, 3), composed = model::compose(model, markers);
    FaceRenderer renderer(model, composed);
    model::Motion instant;
    instant.coefficients = Eigen::Vector4f(100, -200, 50, 300);
    renderer.set_motion(instant);
    draw_once(renderer);
    expect_points_near(renderer.read_positions(), model::evaluate(model, composed, instant), 1e-3f);
    EXPECT_LE((renderer.read_positions().row(3) - model.neutral.positions.row(3)).norm(), 1e-6f) << "no terms: still";
}

TEST_F(ShapeGLTest, CorrectionsMoveTheirPointsAndAreGoneInTheNextInstant) {
    const model::FaceModel model = ball_with_eyes();
    model::LinearMotion motion = random_motion(3 * model.point_count(), 37, 1);
    motion.corrected = true;
    FaceRenderer renderer(model, motion);
    model::Motion instant = some_motion(37);
    const Points plain = model::evaluate(model, motion, instant);
    for (std::uint32_t at = 5; at < 900; at += 7) instant.corrections.push_back({at, float(at % 11) - 5});
    renderer.set_motion(instant);
    draw_once(renderer);
    const Points truth = model::evaluate(model, motion, instant);
    EXPECT_GT((truth - plain).rowwise().norm().maxCoeff(), 4.9f);
    expect_points_near(renderer.read_positions(), truth, 1e-3f);
    renderer.set_motion(some_motion(37));
    draw_once(renderer);
    expect_points_near(renderer.read_positions(), plain, 1e-3f);
}

TEST_F(ShapeGLTest, ACorrectedMarkerMovesAllVerticesThatHangOnIt) {
    model::FaceModel model;
    model.neutral = make_card(100);
    model::BlendBase blend;
    blend.markers = model.neutral.positions.topRows(2);
    blend.sites = {Site::at_vertex(0), Site::at_vertex(1)};
    blend.row_start = {0, 1, 2, 4, 4};
    blend.terms = {{0, 1.0f}, {1, 1.0f}, {0, 0.4f}, {1, 0.6f}};
    model.base = blend;
    model::LinearMotion markers = random_motion(6, 4, 3);
    markers.corrected = true;
    const model::LinearMotion composed = model::compose(model, markers);
    FaceRenderer renderer(model, composed);
    model::Motion instant;
    instant.coefficients = Eigen::Vector4f(100, -200, 50, 300);
    const Points plain = model::evaluate(model, composed, instant);
    instant.corrections = {{1, 10.0f}, {4, 5.0f}};
    renderer.set_motion(instant);
    draw_once(renderer);
    const Points moved = model::evaluate(model, composed, instant);
    expect_points_near(renderer.read_positions(), moved, 1e-3f);
    EXPECT_NEAR(moved(2, 1) - plain(2, 1), 0.4f * 10 + 0.6f * 5, 1e-4f);
    EXPECT_EQ(moved.row(3), plain.row(3));
}

/// What holds lids and lips moves something by more than `least` mm, on the GPU as on the CPU.
void expect_held(model::FaceModel model, float least) {
    const model::LinearMotion motion = random_motion(3 * model.point_count(), 7, 5);
    FaceRenderer renderer(model, motion);
    const model::Motion instant = some_motion(7);
    renderer.set_motion(instant);
    draw_once(renderer);
    const Points held = model::evaluate(model, motion, instant);
    expect_points_near(renderer.read_positions(), held, 1e-3f);
    model.lids.clear();
    model.contacts.clear();
    EXPECT_GT((held - model::evaluate(model, motion, instant)).rowwise().norm().maxCoeff(), least) << "mm: they were held";
}

TEST_F(ShapeGLTest, LidsStayOnTheirEyeballsAsOnTheCpu) {
    model::FaceModel model = ball_with_eyes();
    for (std::uint32_t eye = 0; eye < 2; ++eye) {
        model::Lid lid{Vec3(eye ? 30 : -30, 5, 60), {}};
        for (std::uint32_t v = 300 + 100 * eye; v < 380 + 100 * eye; ++v) lid.members.push_back({v, 1, 1, float(v % 5) / 4});
        model.lids.push_back(std::move(lid));
    }
    expect_held(std::move(model), 1);
}

TEST_F(ShapeGLTest, LipsAreHeldApartAsOnTheCpu) {
    model::FaceModel model = ball_with_eyes();
    model::Contact& contact = model.contacts.emplace_back();
    for (std::uint32_t i = 0; i < 200; ++i) contact.pairs.push_back({300 + i, 500 - i});
    for (std::uint32_t v = 200; v < 700; ++v) contact.members.push_back({v, (v % 2 ? 1.0f : -1.0f) * float(v % 9 + 1) / 9});
    model::Contact& other = model.contacts.emplace_back();
    for (std::uint32_t i = 0; i < 9; ++i) other.pairs.push_back({20 + i, 60 + i});
    for (std::uint32_t v = 10; v < 90; ++v) other.members.push_back({v, v % 2 ? 0.5f : -1.0f});
    expect_held(std::move(model), 10);
}

TEST_F(ShapeGLTest, SwitchedOffStepsAreLeftOut) {
    const model::FaceModel model = ball_with_eyes();
    const model::LinearMotion motion = random_motion(3 * model.point_count(), 5, 4);
    FaceRenderer renderer(model, motion);
    renderer.set_motion(some_motion(5));
    Look still;
    still.steps = {.motion = false, .gaze = false, .pose = false};
    draw_once(renderer, still);
    expect_points_near(renderer.read_positions(), model.neutral.positions, 1e-4f);
    draw_once(renderer);
    expect_points_near(renderer.read_positions(), model::evaluate(model, motion, some_motion(5)), 1e-3f);
}

TEST_F(ShapeGLTest, PositionsFromOutsideAreDrawnAsTheyAre) {
    const model::FaceModel model = ball_with_eyes();
    FaceRenderer renderer(model);
    const Points points = model.neutral.positions * 1.1f;
    renderer.set_positions(points);
    draw_once(renderer);
    expect_points_near(renderer.read_positions(), points, 0);
    // Without the poles, where triangles have no area worth a direction.
    const Points normals = vertex_normals(points, model.neutral.triangles);
    const Eigen::Index inner = normals.rows() - 2 * 33;
    expect_points_near(renderer.read_normals().middleRows(33, inner), normals.middleRows(33, inner), 2e-4f);
}

}  // namespace
}  // namespace mien::render
