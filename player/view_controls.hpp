#pragma once

#include <string_view>

#include "render/camera.hpp"
#include "render/look.hpp"

namespace mien::player {

/// What the mouse does to the camera: left button orbits, right or middle pans, the wheel zooms. Pixels in, camera out.
class ViewControls {
public:
    void reset(const render::OrbitCamera& home) { camera_ = home_ = home; }
    /// The picture has another shape, in which the first view would be `home`: what was chosen since is kept.
    void reshape(const render::OrbitCamera& home);
    void drag(bool pans, double dx, double dy, int picture_height);   ///< pixels, y down
    void wheel(double notches);
    const render::OrbitCamera& camera() const { return camera_; }

private:
    render::OrbitCamera camera_, home_;
};

inline constexpr int kLayerCount = 8;
/// Switches layer 1 .. kLayerCount of the look: texture, motion, head pose, gaze, light; of a trained model: medium detail, fine
/// detail, learnt colour. The name says what is switched.
std::string_view toggle_layer(render::Look& look, int layer);
bool layer_on(const render::Look& look, int layer);

}  // namespace mien::player
