#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string_view>

#include "core/geometry.hpp"

namespace mien::render {

/// Where a picture is taken from, mm and radians.
struct Camera {
    Vec3 eye{0, 0, 600};
    Vec3 target{0, 0, 0};
    Vec3 up{0, 1, 0};
    float fov = 0.48f;                     ///< vertical angle of the whole picture
    float near = 10, far = 10000;

    Eigen::Matrix4f view() const;
    /// To OpenGL clip coordinates; aspect: width / height.
    Eigen::Matrix4f projection(float aspect) const;
};

/// The pixels, from the lower left, that a box (mm) can cover in a picture of that size: all where it reaches behind the eye.
Eigen::AlignedBox2i pixels_of(const Eigen::AlignedBox3f& box, const RigidPose& pose, const Camera& camera, int width, int height);

/// left, right: the actor's own side turns to the camera.
enum class View { front, left, right };
inline constexpr float kSideYaw = 0.70f;   // 40 degrees: both eyes still show
std::optional<View> parse_view(std::string_view name);
constexpr float yaw_of(View view) { return view == View::front ? 0 : view == View::left ? kSideYaw : -kSideYaw; }

/// A camera on a sphere around what it looks at; what the mouse moves.
struct OrbitCamera {
    Vec3 centre = Vec3::Zero();            ///< mm
    float yaw = 0;                         ///< > 0 to +x, the actor's left
    float pitch = 0;                       ///< > 0 above
    float distance = 600;                  ///< mm
    float fov = 0.48f;                     ///< 27.5 degrees, a portrait lens
    Vec2 pan = Vec2::Zero();               ///< mm to the right and up in the picture

    Camera camera() const;
    void orbit(float yaw_by, float pitch_by);   ///< pitch stops short of the poles
    void zoom(float factor);                    ///< distance times factor, within 50 mm .. 10 m
};

/// A camera that shows the whole box, with some air, in a picture of that aspect (width / height). The distance is the
/// same for every yaw.
OrbitCamera frame_box(const Eigen::AlignedBox3f& box, float aspect, View view = View::front);
Eigen::AlignedBox3f bounding_box(PointsRef points);   ///< rows with NaN are left out; an empty box becomes a unit one

}  // namespace mien::render
