#include "samples/head_surface.hpp"

#include <random>

namespace mien::samples {
namespace {

/// One tilted section of the loft: a front point on the midline, the widest point at the side, a back point.
struct Section {
    double t, front_y, front_z, half_width, side_y, side_z, back_y, back_z, square;
};

// An adult between the sexes' means: head length about 190, breadth 150, cheek bones 135, vertex to chin 225.
constexpr Section kSections[] = {
    {-190, -182, 45, 90, -166, -24, -148, -88, 0.00},  // where the shoulders begin
    {-176, -164, 43.5, 71, -150, -21, -128, -79, 0.00},
    {-162, -147, 44, 59, -133, -18, -108, -72, 0.00},
    {-146, -129, 47.5, 52, -108, -15, -86, -67, 0.03},  // throat
    {-132, -121.5, 57, 51.0, -90, -12, -70, -67, 0.04},   // under the chin
    {-121, -117.5, 77, 51.5, -79, -7, -58, -70, 0.08},
    {-112, -111.5, 91, 53.0, -69, -4, -49, -74, 0.12},  // border of the jaw
    {-101, -101, 96.5, 55.0, -57, -3, -38, -80, 0.16},  // pogonion
    {-87, -87, 97.5, 58.7, -45, -3, -29, -86, 0.22},
    {-70, -70, 100.5, 62.2, -34, -3, -20, -90, 0.27},  // mouth
    {-50, -50, 101.0, 66.0, -23, -3, -10, -93, 0.31},
    {-30, -30, 97, 68.5, -10, -2, 2, -95.5, 0.33},  // cheek bones
    {-10, -10, 92.5, 71, 3, -3, 14, -97, 0.29},
    {8, 8, 92, 72, 16, -6, 26, -97, 0.22},  // nasion
    {25, 25, 96, 73, 30, -9, 38, -96, 0.17},  // brow
    {45, 45, 97, 75, 46, -12, 52, -92.6, 0.12},
    {65, 63.5, 91.5, 73, 63.5, -13, 66, -86.5, 0.08},
    {85, 81.3, 79.5, 65.5, 80, -13, 80.5, -76.9, 0.04},
    {105, 96, 60, 53, 94.5, -13, 93, -64.4, 0.00},
    {125, 106.2, 35, 37, 105, -13, 103.5, -48.3, 0.00},
    {143, 111, 12.5, 20, 110.7, -13, 110, -30.8, 0.00},
    {160, 112.4, -11, 0, 112.4, -11, 112.4, -11, 0.00},  // vertex
};

Spline column(double Section::*member) {
    std::vector<double> t, v;
    for (const Section& s : kSections) t.push_back(s.t), v.push_back(s.*member);
    return Spline(t, v);
}

/// What cheek bone, masseter and jaw add to the width of the loft at one side, mm: full from the temple down to the lower
/// border of the mandible, which rises from the chin to the gonial angle below the ear lobe, and gone behind the ramus.
double beside_jaw(double y, double z) {
    const double border = mix(-78, -111, smooth_step(2, 78, z)), above = smooth_step(-12, 13, y - border);
    const double ramus = mix(0.45, 1, smooth_step(-22, 12, z)), front = smooth_step(79, 46, z);
    const double height = 4.2 * smooth_step(34, 0, y) + 4.6 * bell(y, -62, 26);
    return front * (height * ramus * above - 0.9 * bell(y - border, -13, 8) * smooth_step(-8, 14, z));
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
    p.nose_width = vary(0.12);
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
    p.nose_tip = aside(1.8);
    p.nose_bridge = aside(1.4);
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
      front_square_(column(&Section::square)) {}

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
    const double rise = upper ? 6.4 * std::pow(std::sin(pi * std::pow(q, 0.86)), 0.74)
                              : -4.7 * std::pow(std::sin(pi * std::pow(q, 1.22)), 0.78);
    return {x, p_.eye_y + line + rise * p_.eye_opening};
}

double HeadSurface::lip_line(double x) const {
    const double w = mouth_half_width();
    return -70.3 - 0.9 * bell(x, 0, 4.5) + 0.5 * bell(x, 10, 5) + 1.9 * std::pow(x / w, 3);
}

double HeadSurface::upper_border(double x) const {
    const double w = mouth_half_width(), q = std::min(x / w, 1.0);
    const double rise =
        7.6 * std::pow(1 - std::pow(q, 1.95), 0.9) - 1.2 * bell(x, 0, 2.6) + 0.6 * bell(x, 5.8, 2.8);
    return lip_line(w) + rise * p_.lips + 0.4 * (1 - q);
}

double HeadSurface::lower_border(double x) const {
    const double w = mouth_half_width(), q = std::min(x / w, 1.0);
    return lip_line(w) - 10.0 * p_.lips * std::pow(1 - std::pow(q, 2.2), 0.8);
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
    // The muscle from behind the ear to the breastbone, and the larynx.
    if (y < -60) {
        const double down = std::clamp((-60 - y) / 105, 0.0, 1.0);
        const double strap = smooth_step(-70, -95, y) * bell(p.z(), mix(-22, 34, std::pow(down, 1.3)), mix(12, 9, down));
        out += 2.6 * strap * Vec3d(x / (std::abs(x) + 12), 0, 0.35);
        out.z() += 2.2 * bell(x, y, 0, -133, 9, 7) * smooth_step(0, 30, p.z());
    }
    out.x() += beside_jaw(y, p.z()) * smooth_step(10, 40, x) * p_.jaw;
    // Everything here belongs to the front; it fades towards the ears.
    const double facing = smooth_step(-5, 40, p.z());
    if (facing <= 0) return out;
    double dx = 0, dz = 0;
    // Orbits: deep beside the nose and under the brow.
    dz -= 8.0 * bell(x, y, 18, 2, 7.0, 9);
    dz -= 5.6 * bell(x, y, 33, 8, 11, 6);
    dz -= 2.0 * bell(x, y, 29, -13, 12, 6);
    dz += 2.2 * bell(x, y, 29, 12, 13, 4);  // fuller again over the upper lid's crease
    // Brow ridge and the bump over the nose.
    dz += p_.brow * 2.4 * bell(x, y, 24, 19, 12, 6) + 0.9 * bell(x, y, 0, 20, 9, 8);
    dz += 1.0 * bell(x, y, 40, 19, 10, 6);
    // Cheek bones, the hollow below them, the fold from nose to mouth.
    dz += 3.0 * bell(x, y, 43, -25, 12, 9);
    dz += 0.4 * bell(x, y, 27, -34, 9, 9) - 1.6 * bell(x, y, 31, -42, 9, 11);
    dz -= 2.0 * bell(x, y, 47, -62, 10, 14);
    const double fold_x = mix(19, 32, smooth_step(-38, -72, y));
    dz -= 0.9 * bell(x, fold_x, 2.6) * smooth_step(-38, -46, y) * smooth_step(-76, -64, y);
    // Seen from the side of the face: cheek bone, the hollow under it, the temple. Not near the lids and lips.
    const double beside = smooth_step(44, 60, x);
    dx += beside * (0.9 * bell(y, p.z(), -17, 42, 9, 22) - 1.5 * bell(y, p.z(), -52, 48, 15, 17) -
                    1.5 * bell(y, p.z(), 22, 55, 13, 16));
    // Muzzle, philtrum, mentolabial fold, chin.
    dz += 1.8 * bell(x, y, 0, -64, 19, 12);
    // The lips lie on the dental arch: the corners of the mouth some ten millimetres behind its middle.
    dz += 2.2 * bell(x, y, 0, -69, 12, 9) - 3.6 * bell(x, y, 28, -70, 9, 11);
    // The lips' borders stand out: the upper lip looks down, the lower one rolls out over its hollow.
    dz += 1.3 * bell(y, upper_border(x) + 0.3, 2.8) * smooth_step(26, 8, x) + 0.8 * bell(y, lower_border(x), 2.4) * smooth_step(24, 8, x);
    // Corners of the mouth lie in a dimple between fuller cheek and chin.
    dz += 1.1 * bell(x, y, 33, -70, 5, 9) - 0.9 * bell(x, y, 27.5 * p_.mouth, -70, 2.6, 4);
    dz += (0.55 * bell(x, 4.8, 2.3) - 0.75 * bell(x, 0, 2.7)) * smooth_step(-47, -52, y) *
          smooth_step(-66, -61, y);
    dz -= 2.2 * bell(x, y, 0, -86.5, 13, 4.5);
    dz += p_.chin * 3.0 * bell(x, y, 0, -101, 12, 8.5);
    out += facing * (Vec3d(dx, 0, dz) + nose_offset(p_, x, y));
    // Lids: skin that lies on a ball a little larger than the eye, rising out of the orbit.
    const Vec3d e = eye_centre();
    const double ball = p_.eye_radius + mix(1.35, 1.75, smooth_step(-6, 3, y - p_.eye_y)),
                 d2 = square(x - e.x()) + square(y - e.y());
    const double near_lid = smooth_step(mix(17, 21, smooth_step(-4, 4, y - e.y())), 12, std::sqrt(d2));
    if (near_lid > 0) {
        const double lid = e.z() + std::sqrt(std::max(ball * ball - d2, 0.0) + 1.0);
        out.z() =
            mix(out.z(), smooth_max(out.z(), lid, mix(4.0, 2.0, smooth_step(-3, 3, y - e.y()))), near_lid);
        // The crease of the upper lid, and a faint one under the lower lid, along the fissure: q as in lid_margin.
        const double q = (x - (e.x() - 14.5)) / 27.7, inside = std::clamp(q, 0.0, 1.0);
        const double arch = std::sin(pi * std::clamp(inside, 0.06, 0.94));
        out.z() -= 1.1 * bell(y, lid_margin(true, inside).y() + 2.2 + 2.0 * arch, 0.9) * smooth_step(0.0, 0.25, q) *
                   smooth_step(1.25, 0.8, q);
        out.z() -= 0.5 * bell(y, lid_margin(false, inside).y() - 5.0 * arch, 1.2) * smooth_step(0.05, 0.3, q) *
                   smooth_step(1.0, 0.7, q);
    }
    return out;
}

}  // namespace mien::samples
