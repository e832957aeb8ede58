#include "samples/head_surface.hpp"

#include <random>

namespace mien::samples {
namespace {

/// One tilted section of the loft: a front point on the midline, the widest point at the side, a back point.
struct Section {
    double t, front_y, front_z, half_width, side_y, side_z, back_y, back_z, square;
};

// Heights and depths follow adult means of Farkas (1994): vertex to menton 225, head length 190, head breadth
// 152, zygion to zygion 135, gonion to gonion 105, nasion to menton 118.
constexpr Section kSections[] = {
    {-190, -162, 22, 63, -158, -26, -150, -86, 0.00},  // end of the neck
    {-162, -141, 25, 57, -132, -27, -114, -76, 0.00},
    {-146, -127, 31, 54, -108, -26, -87, -73, 0.00},  // throat
    {-132, -120, 49, 53, -90, -20, -70, -73, 0.02},   // under the chin
    {-121, -115.5, 71, 54, -78, -10, -58, -76, 0.05},
    {-112, -110, 87, 56, -67, -4, -49, -80, 0.05},    // border of the jaw
    {-101, -101, 94, 58.5, -55, -3, -38, -85, 0.03},  // pogonion
    {-87, -87, 94.5, 61, -44, -3, -29, -89, 0.00},
    {-70, -70, 97.5, 63.5, -34, -3, -20, -92, 0.00},  // mouth
    {-50, -50, 98.5, 66, -23, -3, -10, -94, 0.00},
    {-30, -30, 95.5, 68.5, -10, -2, 2, -95.5, 0.02},  // cheek bones
    {-10, -10, 92, 70.5, 3, -3, 14, -97, 0.06},
    {8, 8, 92, 72, 16, -6, 26, -97, 0.10},    // nasion
    {25, 25, 96, 73, 30, -9, 38, -96, 0.10},  // brow
    {45, 45, 95.5, 75, 46, -12, 52, -92.6, 0.08},
    {65, 63.5, 88.5, 73, 63.5, -13, 66, -86.5, 0.05},
    {85, 81.3, 76.5, 65.5, 80, -13, 80.5, -76.9, 0.02},
    {105, 96, 58, 53, 94.5, -13, 93, -64.4, 0.00},
    {125, 106.2, 35, 37, 105, -13, 103.5, -48.3, 0.00},
    {143, 111, 12.5, 20, 110.7, -13, 110, -30.8, 0.00},
    {160, 112.4, -11, 0, 112.4, -11, 112.4, -11, 0.00},  // vertex
};

Spline column(double Section::*member) {
    std::vector<double> t, v;
    for (const Section& s : kSections) t.push_back(s.t), v.push_back(s.*member);
    return Spline(t, v);
}

}  // namespace

HeadProportions head_proportions(std::uint64_t seed) {
    HeadProportions p;
    if (seed == 0) return p;
    std::mt19937_64 random(seed);
    // Only the generator's own integers: distributions of the standard library differ between
    // implementations.
    const auto vary = [&](double amount) {
        return 1 + amount * (double(random() >> 11) / double(1ull << 52) - 1);
    };
    p.width = vary(0.025);
    p.jaw = vary(0.05);
    p.nose = vary(0.10);
    p.nose_width = vary(0.09);
    p.lips = vary(0.18);
    p.mouth = vary(0.05);
    p.chin = vary(0.25);
    p.brow = vary(0.5);
    p.eye_opening = vary(0.07);
    p.eye_x *= vary(0.025);
    const auto aside = [&](double amount) { return (vary(1) - 1) * amount; };
    p.nose_aside = aside(0.7);
    p.chin_aside = aside(0.9);
    p.mouth_tilt = aside(0.5);
    p.brow_tilt = aside(0.8);
    return p;
}

HeadSurface::HeadSurface(const HeadProportions& proportions)
    : p_(proportions),
      front_y_(column(&Section::front_y)),
      front_z_(column(&Section::front_z)),
      half_width_(column(&Section::half_width)),
      side_y_(column(&Section::side_y)),
      side_z_(column(&Section::side_z)),
      back_y_(column(&Section::back_y)),
      back_z_(column(&Section::back_z)),
      front_square_(column(&Section::square)),
      nose_dy_({-60, -52, -48, -45, -42, -39, -36, -32, -20, 0, 20},
               {0, 0, -0.4, -1.2, -2.0, -2.2, -1.4, -0.4, 0, 0, 0}),
      nose_dz_({-62, -55, -50, -47, -44, -41, -38, -35, -31, -26, -18, -8, 0, 7, 14, 22},
               {2.2, 3.0, 4.2, 6.5, 11, 17, 21.0, 22.0, 21.0, 18.2, 13.2, 7.4, 3.6, 1.6, 0.4, 0}),
      nose_width_({-60, -50, -44, -38, -32, -24, -14, -4, 6, 16},
                  {12, 11, 9.6, 9.6, 9.6, 8.6, 8.2, 7.6, 7.5, 8.5}) {}

Vec3d HeadSurface::loft(double phi, double t) const {
    const double c = std::cos(phi), s = std::sin(phi);
    const double f = c > 0 ? c * (1 + front_square_(t) * s * s) : c;
    const double side_y = side_y_(t), front_y = front_y_(t), back_y = back_y_(t), side_z = side_z_(t);
    const double jaw = mix(1, p_.jaw, smooth_step(-20, -70, t) * smooth_step(-170, -130, t));
    const double z = c > 0 ? mix(side_z, front_z_(t), f) : mix(side_z, back_z_(t), -f);
    return {half_width_(t) * p_.width * jaw * s,
            side_y + f * (front_y - back_y) / 2 + f * f * ((front_y + back_y) / 2 - side_y), z};
}

Vec2d HeadSurface::from_front(double x, double y) const {
    Vec2d at(std::asin(std::clamp(x / 72, -0.95, 0.95)), y);
    for (int i = 0; i < 12; ++i) {
        const double e = 1e-4;
        const Vec3d p = loft(at[0], at[1]), pu = loft(at[0] + e, at[1]), pv = loft(at[0], at[1] + e);
        const double a = (pu.x() - p.x()) / e, b = (pv.x() - p.x()) / e, c = (pu.y() - p.y()) / e,
                     d = (pv.y() - p.y()) / e, dx = x - p.x(), dy = y - p.y();
        const double determinant = a * d - b * c;
        at += Vec2d(d * dx - b * dy, a * dy - c * dx) / determinant;
    }
    return at;
}

Vec3d HeadSurface::front(double x, double y) const {
    const Vec2d at = from_front(x, y);
    return skin(at[0], at[1]);
}

Vec3d HeadSurface::side(double y, double z) const {
    Vec2d at(pi / 2 - (z + 3) / 90, y - 20);
    for (int i = 0; i < 16; ++i) {
        const double e = 1e-4;
        const Vec3d p = loft(at[0], at[1]), pu = loft(at[0] + e, at[1]), pv = loft(at[0], at[1] + e);
        const double a = (pu.z() - p.z()) / e, b = (pv.z() - p.z()) / e, c = (pu.y() - p.y()) / e,
                     d = (pv.y() - p.y()) / e, dz = z - p.z(), dy = y - p.y();
        at += Vec2d(d * dz - b * dy, a * dy - c * dz) / (a * d - b * c);
    }
    return skin(at[0], at[1]);
}

Vec2d HeadSurface::lid_margin(bool upper, double q) const {
    // Corners: the inner one lower; the arches of the lids peak inside (upper) and outside (lower) of the
    // middle.
    const double x = mix(p_.eye_x - 14.5, p_.eye_x + 13.2, q);
    const double line = mix(-1.6, 0.9, q);
    const double rise = upper ? 5.7 * std::pow(std::sin(pi * std::pow(q, 0.86)), 0.72)
                              : -4.7 * std::pow(std::sin(pi * std::pow(q, 1.22)), 0.78);
    return {x, p_.eye_y + line + rise * p_.eye_opening};
}

double HeadSurface::lip_line(double x) const {
    const double w = mouth_half_width();
    return -70 - 0.9 * bell(x, 0, 4.5) + 0.5 * bell(x, 10, 5) + 0.3 * square(x / w);
}

double HeadSurface::upper_border(double x) const {
    const double w = mouth_half_width(), q = std::min(x / w, 1.0);
    const double rise =
        7.9 * std::pow(1 - std::pow(q, 1.7), 0.95) - 1.3 * bell(x, 0, 2.6) + 0.5 * bell(x, 5.5, 2.5);
    return lip_line(w) + rise * p_.lips + 0.4 * (1 - q);
}

double HeadSurface::lower_border(double x) const {
    const double w = mouth_half_width(), q = std::min(x / w, 1.0);
    return lip_line(w) - 9.6 * p_.lips * std::pow(1 - q * q, 0.8);
}

Vec3d HeadSurface::skewed(const Vec3d& p) const {
    const double facing = smooth_step(20, 60, p.z()), y = p.y();
    const double side = std::clamp(p.x() / 25, -1.4, 1.4);
    return p + facing * Vec3d(p_.nose_aside * bell(p.x(), y, 0, -34, 16, 11) +
                                  p_.chin_aside * bell(y, -98, 18) * smooth_step(-45, -75, y),
                              side * (p_.mouth_tilt * bell(y, -70, 10) + p_.brow_tilt * bell(y, 26, 7)), 0);
}

Vec3d HeadSurface::sculpt(const Vec3d& p) const {
    const double x = p.x(), y = p.y();
    Vec3d out = p;
    // Everything here belongs to the front; it fades towards the ears.
    const double facing = smooth_step(-5, 40, p.z());
    if (facing <= 0) return out;
    double dz = 0;
    // Orbits: deep beside the nose and under the brow.
    dz -= 9.3 * bell(x, y, 18, 3, 6.5, 9);
    dz -= 6.5 * bell(x, y, 33, 8, 11, 6);
    dz -= 2.0 * bell(x, y, 29, -13, 12, 6);
    // Brow ridge and the bump over the nose.
    dz += p_.brow * 2.4 * bell(x, y, 24, 19, 12, 5);
    dz += 1.0 * bell(x, y, 40, 19, 10, 6);
    // Cheek bones, the hollow below them, the fold from nose to mouth.
    dz += 3.0 * bell(x, y, 43, -25, 12, 9);
    dz += 2.0 * bell(x, y, 27, -34, 9, 9);
    dz -= 2.0 * bell(x, y, 47, -62, 10, 14);
    const double fold_x = mix(19, 32, smooth_step(-38, -72, y));
    dz -= 0.9 * bell(x, fold_x, 2.6) * smooth_step(-38, -46, y) * smooth_step(-76, -64, y);
    // Muzzle, philtrum, mentolabial fold, chin.
    dz += 1.5 * bell(x, y, 0, -66, 17, 11);
    dz += (0.8 * bell(x, 4.6, 1.9) - 1.0 * bell(x, 0, 2.4)) * smooth_step(-47, -52, y) *
          smooth_step(-66, -61, y);
    dz -= 1.8 * bell(x, y, 0, -87, 14, 4.5);
    dz += p_.chin * 3.0 * bell(x, y, 0, -102, 11, 8);
    // Nose: a ridge of changing width, the tip, the wings.
    const double width = nose_width_(y) * p_.nose_width;
    const double ridge =
        std::exp(-std::pow(x / width, 2.3)) * smooth_step(-66, -54, y) * smooth_step(24, 12, y);
    dz += p_.nose * nose_dz_(y) * ridge;
    double dy = nose_dy_(y) * ridge, dx = 0;
    // The wings end sharply below and softly above; a groove parts them from the tip and from the cheek.
    const double wing_y = y > -39.5 ? bell(y, -39.5, 6.0) : bell(y, -39.5, 3.0);
    const double wing = bell(x, 12.4 * p_.nose_width, 3.7) * wing_y;
    dz += 9.5 * wing - 1.3 * bell(x, y, 9.6 * p_.nose_width, -31.5, 2.6, 3.6) +
          1.6 * bell(x, y, 0, -35, 5.5, 4.5);
    dx += 1.4 * wing;
    dy -= 1.0 * wing;
    dz -= 1.4 * bell(x, y, 18.2 * p_.nose_width, -38, 1.9, 4.5);
    out += facing * Vec3d(dx, dy, dz);
    // Lids: skin that lies on a ball a little larger than the eye, rising out of the orbit.
    const Vec3d e = eye_centre();
    const double ball = p_.eye_radius + mix(1.35, 1.75, smooth_step(-6, 3, y - p_.eye_y)),
                 d2 = square(x - e.x()) + square(y - e.y());
    const double near_lid = smooth_step(mix(17, 21, smooth_step(-4, 4, y - e.y())), 12, std::sqrt(d2));
    if (near_lid > 0) {
        const double lid = e.z() + std::sqrt(std::max(ball * ball - d2, 0.0) + 1.0);
        out.z() =
            mix(out.z(), smooth_max(out.z(), lid, mix(4.0, 2.0, smooth_step(-3, 3, y - e.y()))), near_lid);
    }
    return out;
}

}  // namespace mien::samples
