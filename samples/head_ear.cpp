#include <array>
#include <initializer_list>

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

/// How far the rim stands off the head, mm: it grows out of the cheek in front, lies back at some twenty degrees above and
/// behind, and comes home in the lobe.
double protrusion(double psi) {
    static const Spline rim({-90, -60, -30, 0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330, 360, 390},
                            {6.5, 3.5, 2.5, 2.5, 4.5, 7.5, 11.0, 14.5, 16.5, 17.0, 16.0, 12.0, 6.5, 3.5, 2.5, 2.5, 4.5});
    double degrees = psi * 180 / pi;
    degrees -= 360 * std::floor(degrees / 360);
    return rim(degrees);
}

constexpr double kMiddleY = -15, kMiddleZ = -14;
constexpr double kLean = 0.21;  // the ear's length leans back from the vertical, rad

double off_line(double a, double b, std::initializer_list<Vec2d> line) {
    double best = 1e9;
    for (const Vec2d* p = line.begin(); p + 1 != line.end(); ++p) {
        const Vec2d q(a - p->x(), b - p->y()), along = p[1] - *p;
        best = std::min(best, (q - std::clamp(q.dot(along) / along.squaredNorm(), 0.0, 1.0) * along).norm());
    }
    return best;
}

/// The inner side of the shell over its rim, mm, at a mm to the front and b mm up; s: share of the outline.
/// `cartilage` is 0 in the lobe, which has neither rim nor groove.
double relief(double a, double b, double s, double cartilage) {
    double h = -2.8 * smooth_step(1.0, 0.7, s);
    h -= 2.8 * bell(s, 0.83, 0.06) * cartilage * smooth_step(9, 2, a) * smooth_step(-20, -8, b + 0.4 * a);  // scapha
    h -= 1.6 * bell(s, 0.83, 0.07) * cartilage * smooth_step(8, 14, b) * smooth_step(-2, 8, a);
    h += 2.1 * bell(off_line(a, b, {{-3, -15}, {-9, -7}, {-10, 3}, {-7, 11}, {-5, 19}}), 0, 2.3) * cartilage;  // antihelix
    h += 2.0 * bell(off_line(a, b, {{-7, 10}, {4, 12}}), 0, 2.0);
    h -= 1.8 * bell(a, b, 1, 17, 3.2, 2.8);                                                     // triangular fossa
    const double bowl = square((a - 1.5) / 8.0) + square((b + 3.5) / 10.0);
    h -= 9.5 * std::exp(-bowl * bowl);                                                          // concha
    h += 5.0 * bell(off_line(a, b, {{12, 6}, {1, 1.5}}), 0, 1.8);                               // crus of the helix
    h += 6.5 * bell(a, b, 9.5, -5, 2.4, 4.0) + 3.0 * bell(a, b, 0, -14.5, 3.4, 2.4);            // tragus, antitragus
    h -= 3.0 * bell(a, b, 6, -12, 2.0, 2.2);
    return h;
}

}  // namespace

double ear_angle(const Vec3d& p) {
    const double y = p.y() - kMiddleY, z = p.z() - kMiddleZ;
    return std::atan2(-z * std::sin(kLean) + y * std::cos(kLean), z * std::cos(kLean) + y * std::sin(kLean));
}

Vec3d ear_point(const HeadSurface& surface, int ring, double psi) {
    psi = std::remainder(psi, 2 * pi);
    const double c = std::cos(psi), s = std::sin(psi);
    const double behind = smooth_step(0.55, -0.75, c);
    const double lobe = smooth_step(-0.55, -0.95, s);
    const double rim = protrusion(psi);
    static constexpr double kScale[kEarRings] = {1.16, 0.90, 0.80, 0.93, 1.0,  0.955, 0.905, 0.855,
                                                 0.80, 0.73, 0.65, 0.56, 0.46, 0.36,  0.25,  0.13};
    static constexpr double kBack[] = {0, -0.3, 0.45, 0.85};  // share of the rim's height, behind the shell
    double scale = kScale[ring], height;
    const double front = std::max(1 - behind, lobe);
    if (ring <= 3) {
        // In front nothing is undercut: the shell grows out of the cheek.
        scale = mix(scale, std::array{1.16, 1.07, 1.03, 1.005}[ring], front);
        height = ring == 1 ? 0.3 : rim * kBack[ring];
    } else {
        const double radius = outline(psi) * scale;
        height = rim + relief(radius * c, radius * s, scale, 1 - lobe);
    }
    height = std::max(height, ring > 8 ? -5.0 : -0.3);

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
