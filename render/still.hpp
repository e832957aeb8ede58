#pragma once

#include <memory>

#include "core/image.hpp"
#include "core/mesh.hpp"
#include "render/camera.hpp"
#include "render/look.hpp"
#include "render/target.hpp"

namespace mien::render {

/// Pictures of one mesh, with a context of its own: for looking at what one has made.
///     StillRenderer still(mesh);
///     still.set_texture(image);
///     Image picture = still.picture(frame_box(bounding_box(mesh.positions), 8 / 9.f).camera(), 640, 720);
class StillRenderer {
public:
    explicit StillRenderer(const Mesh& mesh);   ///< throws EnvironmentError without OpenGL
    ~StillRenderer();
    void set_positions(PointsRef positions);    ///< V x 3 mm
    void set_texture(const Image& picture);
    Image picture(const Camera& camera, int width, int height, const Look& look = {}, Smoothing smoothing = Smoothing::supersample);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::render
