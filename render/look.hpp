#pragma once

#include <array>

#include "core/geometry.hpp"
#include "render/shape_steps.hpp"

namespace mien::render {

/// A far light, in clip space. Colours are linear; a white surface that faces a light of colour 1 shows 1.
struct Light {
    Vec3 towards{0, 0, 1};     ///< unit, from the face to the light
    Vec3 colour{0, 0, 0};
};

struct Lighting {
    Vec3 sky{0.27f, 0.26f, 0.265f};      ///< ambient from above
    Vec3 ground{0.17f, 0.14f, 0.125f};   ///< and from below
    std::array<Light, 3> lights;        ///< key (casts the shadow), fill, rim
    float specular = 1;

    static Lighting studio();
    /// The same light from everywhere: a flat albedo comes out as it went in.
    static Lighting ambient_only();
};

/// How a picture is to look; each part can be switched by itself.
struct Look {
    ShapeSteps steps;
    bool fine = true;           ///< wrinkles and pores of a detail model
    bool polynomial_albedo = true;  ///< colour of a detail model; false: the texture's
    bool texture = true;
    bool lit = true;            ///< false: albedo as it is
    bool shadows = true;
    bool wireframe = false;
    bool backdrop = true;       ///< false: black
    Lighting lighting = Lighting::studio();
};

}  // namespace mien::render
