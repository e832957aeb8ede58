#include "render/look.hpp"

namespace mien::render {

Lighting Lighting::studio() {
    Lighting lighting;
    lighting.lights[0] = {Vec3(-0.62f, 0.56f, 0.74f).normalized(), Vec3(0.98f, 0.92f, 0.85f)};
    lighting.lights[1] = {Vec3(0.80f, 0.05f, 0.62f).normalized(), Vec3(0.22f, 0.215f, 0.21f)};
    lighting.lights[2] = {Vec3(0.62f, 0.42f, -0.66f).normalized(), Vec3(0.60f, 0.62f, 0.67f)};
    return lighting;
}

Lighting Lighting::ambient_only() {
    Lighting lighting;
    lighting.sky = lighting.ground = Vec3::Ones();
    lighting.specular = 0;
    return lighting;
}

}  // namespace mien::render
