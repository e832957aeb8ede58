#include "render/face_renderer.hpp"
#include "tests/detail/small_model.hpp"
#include "tests/render/gl_test.hpp"

namespace mien::render {
namespace {

using DetailGLTest = GLTest;

/// A face that is a small detail model over its thin shell, and a motion of its markers.
struct SmallFace {
    model::FaceModel face;
    model::LinearMotion motion, composed;

    SmallFace() {
        SmallModel small;
        const model::MarkerDriver driver(small.model.neutral, small.model.sites, {}, small.model.marker_triangles);
        face.neutral = small.model.neutral;
        face.base = model::ShellBase{driver.mesh().neutral, small.model.sites, driver.response()};
        face.detail = std::make_shared<model::DetailLayers>(small.model);
        const Eigen::Index M = driver.mesh().neutral.rows();
        motion.mean = Eigen::VectorXf::Zero(3 * M);
        motion.components.resize(3 * M, 3);
        for (int k = 0; k < 3; ++k) {
            const Points offset = Points(small.clip.markers->frame(3 + 5 * k)) - driver.mesh().neutral;
            motion.components.col(k) = Eigen::Map<const Eigen::VectorXf>(offset.data(), 3 * M);
        }
        composed = model::compose(face, motion);
    }
    static model::Motion instant() {
        model::Motion instant;
        instant.coefficients = Eigen::Vector3f(0.6f, -0.3f, 0.5f);
        instant.pose.rotation = Eigen::AngleAxisf(0.2f, Vec3(0.3f, 1, -0.2f).normalized());
        instant.pose.translation = Vec3(5, -3, 20);
        return instant;
    }
};

/// The same, ten times as wide: beyond what the markers ever did.
model::Motion beyond() {
    model::Motion instant = SmallFace::instant();
    instant.coefficients *= 10;
    return instant;
}

void draw_near(FaceRenderer& renderer, const Look& look = {}) {
    Target target(256, 256, Smoothing::none);
    Camera camera;
    camera.fov = 0.1f;  // near enough for the maps in their own size
    renderer.draw(camera, look, target);
}

TEST_F(DetailGLTest, TheGpuMovesVerticesAsTheCpuDoes) {
    const SmallFace small;
    FaceRenderer renderer(small.face, small.composed);
    Points truth;
    for (const model::Motion& instant : {beyond(), SmallFace::instant()}) {
        renderer.set_motion(instant);
        draw_near(renderer);
        truth = model::evaluate(small.face, small.composed, instant);
        EXPECT_LE((renderer.read_positions() - truth).rowwise().norm().maxCoeff(), 1e-3f);
    }

    model::DetailModel unbounded = small.face.detail->model();
    unbounded.axes.extents.resize(0);
    model::FaceModel free = small.face;
    free.detail = std::make_shared<model::DetailLayers>(unbounded);
    const auto torn = [&](const model::Motion& instant) {
        return (model::evaluate(free, small.composed, instant) - model::evaluate(small.face, small.composed, instant)).rowwise().norm().maxCoeff();
    };
    EXPECT_GT(torn(beyond()), 0.1f) << "mm: beyond() is";
    EXPECT_LE(torn(SmallFace::instant()), 1e-3f) << "and this is not";

    Look plain;
    plain.steps.medium = false;
    draw_near(renderer, plain);
    EXPECT_GT((renderer.read_positions() - truth).rowwise().norm().maxCoeff(), 0.2f) << "mm: the medium layer moved them";
}

TEST_F(DetailGLTest, TheGpuEvaluatesMapsAsTheCpuDoes) {
    const SmallFace small;
    FaceRenderer renderer(small.face, small.composed);
    renderer.set_motion(SmallFace::instant());
    draw_near(renderer);
    const FloatMap map = renderer.read_detail();

    const model::DetailModel& model = small.face.detail->model();
    const Eigen::VectorXf offsets = small.composed.mean + small.composed.components * SmallFace::instant().coefficients;
    const Points base = small.face.neutral.positions + ConstPointsMap(offsets.data(), offsets.size() / 3, 3);
    const model::DomainParameters parameters = small.face.detail->parameters(base);
    std::vector<float> fine(model.fine.texels), albedo(3 * model.albedo.texels);
    model::evaluate_plain(model.fine, model.fine_domain, parameters, fine.data());
    model::evaluate_plain(model.albedo, model.fine_domain, parameters, albedo.data());
    ASSERT_EQ(map.width, model.fine_domain.width);
    float height = 0, colour = 0;
    std::size_t deep = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
        const int x = int(model.fine_domain.place[i]) % map.width, y = int(model.fine_domain.place[i]) / map.width;
        height = std::max(height, std::abs(map.at(x, y)[3] - fine[i]));
        // At the border the map gives way to what is around it.
        if (std::min({x, y, map.width - 1 - x, map.height - 1 - y}) < 16) continue;
        ++deep;
        for (std::size_t c = 0; c < 3; ++c) colour = std::max(colour, std::abs(map.at(x, y)[c] - std::max(0.0f, albedo[c * model.albedo.texels + i])));
    }
    EXPECT_LE(height, 1e-3f);
    EXPECT_GT(deep, 100u);
    EXPECT_LE(colour, 1e-3f);
}

}  // namespace
}  // namespace mien::render
