#include "player/view_controls.hpp"

#include <array>
#include <cassert>
#include <cmath>

namespace mien::player {
namespace {

constexpr std::array<std::string_view, kLayerCount> kLayerNames = {"texture", "motion", "head pose", "gaze", "light", "medium detail", "fine detail", "learnt colour"};

bool& layer(render::Look& look, int number) {
    switch (number) {
        case 1: return look.texture;
        case 2: return look.steps.motion;
        case 3: return look.steps.pose;
        case 4: return look.steps.gaze;
        case 6: return look.steps.medium;
        case 7: return look.fine;
        case 8: return look.polynomial_albedo;
        default: return look.lit;
    }
}

}  // namespace

void ViewControls::reshape(const render::OrbitCamera& home) {
    camera_.zoom(home.distance / home_.distance);
    home_ = home;
}

void ViewControls::drag(bool pans, double dx, double dy, int picture_height) {
    if (pans) {
        // What is under the mouse stays under it.
        const float mm = 2 * camera_.distance * std::tan(camera_.fov / 2) / float(picture_height);
        camera_.pan += mm * Vec2(float(dx), float(-dy));
    } else {
        constexpr float kTurn = 3.2f;   // radians for a drag over the whole height
        camera_.orbit(-kTurn * float(dx) / float(picture_height), kTurn * float(dy) / float(picture_height));
    }
}

void ViewControls::wheel(double notches) { camera_.zoom(float(std::pow(0.9, notches))); }

std::string_view toggle_layer(render::Look& look, int number) {
    assert(number >= 1 && number <= int(kLayerNames.size()));
    bool& on = layer(look, number);
    on = !on;
    return kLayerNames[std::size_t(number - 1)];
}

bool layer_on(const render::Look& look, int number) {
    render::Look copy = look;
    return layer(copy, number);
}

}  // namespace mien::player
