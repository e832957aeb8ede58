#include "render/still.hpp"

#include <optional>

#include "render/context.hpp"
#include "render/face_renderer.hpp"

namespace mien::render {
namespace {

model::FaceModel model_of(const Mesh& mesh) {
    model::FaceModel model;
    model.neutral = mesh;
    return model;
}

}  // namespace

struct StillRenderer::State {
    explicit State(const Mesh& mesh) : renderer(model_of(mesh)) {}
    OffscreenContext context;      // first in, last out
    FaceRenderer renderer;
    std::optional<Target> target;
};

StillRenderer::StillRenderer(const Mesh& mesh) : state_(std::make_unique<State>(mesh)) {}
StillRenderer::~StillRenderer() = default;
void StillRenderer::set_positions(PointsRef positions) { state_->renderer.set_positions(positions); }
void StillRenderer::set_texture(const Image& picture) { state_->renderer.set_texture(picture); }

Image StillRenderer::picture(const Camera& camera, int width, int height, const Look& look, Smoothing smoothing) {
    auto& target = state_->target;
    if (!target || target->width() != width || target->height() != height || target->smoothing() != smoothing)
        target.emplace(width, height, smoothing);
    state_->renderer.draw(camera, look, *target);
    return target->read();
}

}  // namespace mien::render
