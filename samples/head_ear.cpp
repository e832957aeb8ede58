#include "samples/head_mesh.hpp"

namespace mien::samples {
namespace {

/// Outline of the ear round the middle of its length: radius (mm) by psi, 0 in front, pi/2 on top.
double outline(double psi) {
    static const Spline radius(
        {-90, -45, 0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 315, 360, 390},
        {28.5, 19.5, 12.5, 17, 26, 30.5, 27.5, 22, 19, 18.5, 21.5, 28.5, 25.5, 19.5, 12.5, 17});
    double degrees = psi * 180 / pi;
    degrees -= 360 * std::floor(degrees / 360);
    return radius(degrees);
}

constexpr double kMiddleY = -15, kMiddleZ = -14;
constexpr double kLean = 0.21;  // the ear's length leans back from the vertical, rad

}  // namespace

double ear_angle(const Vec3d& p) {
    const double y = p.y() - kMiddleY, z = p.z() - kMiddleZ;
    return std::atan2(-z * std::sin(kLean) + y * std::cos(kLean), z * std::cos(kLean) + y * std::sin(kLean));
}

Vec3d ear_point(const HeadSurface& surface, int ring, double psi) {
    // How far the rim stands off the head: nothing in front, most behind and above; the lobe a little.
    psi = std::remainder(psi, 2 * pi);
    const double c = std::cos(psi), s = std::sin(psi);
    const double behind = smooth_step(0.55, -0.75, c);
    const double lobe = smooth_step(-0.55, -0.95, s);
    const double rim = mix(2.5, 15.5, behind) + 3 * smooth_step(0.3, 1.0, s) * (1 - behind) - 4.0 * lobe;
    struct Ring {
        double scale, height, below;  // of the outline; share of the rim's height; mm below it
    };
    // Back of the shell, helix, scapha, antihelix, concha.
    static constexpr Ring kRings[kEarRings] = {
        {1.16, 0, 0},     {0.90, 0, -0.3}, {0.80, 0.45, 0}, {0.93, 0.85, 0}, {1.0, 1, 0.2},
        {0.985, 1, -1.0}, {0.93, 1, -1.5}, {0.86, 1, -0.4}, {0.78, 1, 2.2},  {0.66, 1, 1.6},
        {0.53, 1, 1.8},   {0.42, 1, 7.0},  {0.24, 1, 11.0}};
    const Ring& r = kRings[ring];
    double scale = r.scale, height = rim * r.height - r.below;
    // In front nothing is undercut: the shell grows out of the cheek, with the tragus before the concha.
    const double front = std::max(1 - behind, lobe);
    if (ring <= 3) scale = mix(scale, std::array{1.16, 1.07, 1.03, 1.005}[ring], front);
    if (ring >= 5 && ring <= 9)
        scale = mix(scale, std::array{0.97, 0.93, 0.88, 0.82, 0.74}[ring - 5], 0.8 * front);
    if (ring >= 6 && ring <= 10)
        height += 2.2 * bell(psi, -0.05, 0.35) * std::array{0.3, 0.8, 1.2, 1.3, 0.9}[ring - 6];
    // The lobe has neither rim nor groove.
    if (ring >= 5) height = mix(height, rim - (ring > 9 ? r.below * 0.7 : 0.5), 0.85 * lobe);
    height = std::max(height, ring > 10 ? -5.0 : -0.3);

    const double radius = outline(psi) * scale;
    const double a = radius * c, b = radius * s;
    const double z = kMiddleZ + a * std::cos(kLean) - b * std::sin(kLean),
                 y = kMiddleY + a * std::sin(kLean) + b * std::cos(kLean);
    const Vec3d foot = surface.side(y, z);
    // The shell leans out and back.
    const Vec3d out = Vec3d(1, 0.05, -0.28).normalized();
    return foot + height * out;
}

}  // namespace mien::samples
