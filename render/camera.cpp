#include "render/camera.hpp"

#include <algorithm>
#include <cmath>

namespace mien::render {

Eigen::Matrix4f Camera::view() const {
    const Vec3 back = (eye - target).normalized();
    const Vec3 right = up.cross(back).normalized();
    const Vec3 above = back.cross(right);
    Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
    m.block<1, 3>(0, 0) = right.transpose();
    m.block<1, 3>(1, 0) = above.transpose();
    m.block<1, 3>(2, 0) = back.transpose();
    m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * eye;
    return m;
}

Eigen::Matrix4f Camera::projection(float aspect) const {
    const float scale = 1 / std::tan(fov / 2);
    Eigen::Matrix4f m = Eigen::Matrix4f::Zero();
    m(0, 0) = scale / aspect;
    m(1, 1) = scale;
    m(2, 2) = (far + near) / (near - far);
    m(2, 3) = 2 * far * near / (near - far);
    m(3, 2) = -1;
    return m;
}

std::optional<View> parse_view(std::string_view name) {
    if (name == "front") return View::front;
    if (name == "left") return View::left;
    if (name == "right") return View::right;
    return std::nullopt;
}

Camera OrbitCamera::camera() const {
    const Vec3 towards(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
    const Vec3 right(std::cos(yaw), 0, -std::sin(yaw));
    const Vec3 above = towards.cross(right);
    Camera camera;
    camera.target = centre - pan.x() * right - pan.y() * above;
    camera.eye = camera.target + distance * towards;
    camera.fov = fov;
    camera.near = distance * 0.05f;
    camera.far = distance * 4 + 1000;
    return camera;
}

void OrbitCamera::orbit(float yaw_by, float pitch_by) {
    yaw = std::remainder(yaw + yaw_by, 2 * float(M_PI));
    pitch = std::clamp(pitch + pitch_by, -1.5f, 1.5f);
}

void OrbitCamera::zoom(float factor) { distance = std::clamp(distance * factor, 50.0f, 10000.0f); }

OrbitCamera frame_box(const Eigen::AlignedBox3f& box, float aspect, View view) {
    constexpr float kAir = 1.06f;
    const Vec3 half = box.sizes() / 2;
    OrbitCamera orbit;
    orbit.centre = box.center();
    orbit.yaw = yaw_of(view);
    const float slope = std::tan(orbit.fov / 2);
    // A head turns within the circle around it, so its depth can become its width; the front half is what is near.
    const float width = std::max(half.x(), half.z() * 0.9f);
    orbit.distance = kAir * std::max(half.y() / slope, width / (slope * aspect)) + 0.7f * half.z();
    orbit.distance = std::clamp(orbit.distance, 50.0f, 10000.0f);
    return orbit;
}

Eigen::AlignedBox3f bounding_box(PointsRef points) {
    Eigen::AlignedBox3f box;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        if (points.row(i).allFinite()) box.extend(Vec3(points.row(i).transpose()));
    if (box.isEmpty()) box = Eigen::AlignedBox3f(Vec3::Constant(-0.5f), Vec3::Constant(0.5f));
    return box;
}

Eigen::AlignedBox2i pixels_of(const Eigen::AlignedBox3f& box, const RigidPose& pose, const Camera& camera, int width, int height) {
    const Eigen::AlignedBox2i all(Eigen::Vector2i::Zero(), Eigen::Vector2i(width, height));
    const Eigen::Matrix4f project = camera.projection(float(width) / float(height)) * camera.view();
    Eigen::AlignedBox2f covered;
    for (int i = 0; i < 8; ++i) {
        const Vec3 corner = pose.apply(box.corner(Eigen::AlignedBox3f::CornerType(i)));
        const Eigen::Vector4f clip = project * corner.homogeneous();
        if (clip.w() < camera.near) return all;
        covered.extend(((clip.head<2>() / clip.w()).array() * 0.5f + 0.5f).matrix());
    }
    const Eigen::Array2f size{float(width), float(height)};
    const auto whole = [&](const Vec2& p) { return (p.array() * size).max(-1.0f).min(size + 1).cast<int>().matrix().eval(); };
    Eigen::AlignedBox2i pixels(whole(covered.min()), whole(covered.max()) + Eigen::Vector2i::Ones());
    return pixels.intersection(all);
}

}  // namespace mien::render
