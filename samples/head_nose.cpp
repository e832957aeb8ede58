#include <array>

#include "samples/head_surface.hpp"

namespace mien::samples {
namespace {

/// Minimum with a rounded corner of size k (quadratic, Quilez 2013).
double smooth_min(double a, double b, double k) {
    const double h = std::max(k - std::abs(a - b), 0.0) / k;
    return std::min(a, b) - 0.25 * h * h * k;
}

struct Ball {
    double x, y, h, radius;
};

double ellipsoid(const Vec3d& p, const Vec3d& centre, const Vec3d& radii) {
    const Vec3d q = (p - centre).cwiseQuotient(radii);
    const double length = q.norm();
    return length < 1e-6 ? -radii.minCoeff() : length * (length - 1) / q.cwiseQuotient(radii).norm();
}

/// Distance to balls whose radius changes evenly from one to the next.
template <std::size_t N>
double chain(const Vec3d& p, const std::array<Ball, N>& balls) {
    double best = 1e9;
    for (std::size_t i = 0; i + 1 < N; ++i) {
        const Vec3d a(balls[i].x, balls[i].y, balls[i].h), ab = Vec3d(balls[i + 1].x, balls[i + 1].y, balls[i + 1].h) - a;
        const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
        best = smooth_min(best, (p - a - t * ab).norm() - mix(balls[i].radius, balls[i + 1].radius, t), 1.5);
    }
    return best;
}

/// Signed distance (about) to the left half of a nose on a flat face: x from the midline, y up, h out of the face.
class Nose {
public:
    /// `bridge`: how far it is humped, mm.
    double distance(const Vec3d& p, double bridge) const {
        const double x = std::abs(p.x()), y = p.y();
        // The bridge with its sides: a ridge that runs out into the tip.
        const double ridge = (height_(y) + bridge * bell(y, -12, 8)) * std::exp(-std::pow(x / width_(y), 1.9)) * smooth_step(-45, -33, y);
        double d = smooth_min(p.z(), 0.55 * (p.z() - ridge), 1.5);
        const Vec3d q(x, y, p.z());
        d = smooth_min(d, ellipsoid(q, {0, -37.0, 10.6}, {8.2, 7.6, 9.8}), 4.5);     // tip
        d = smooth_min(d, ellipsoid(q, {6.4, -39.0, 6.0}, {4.6, 4.4, 7.0}), 2.5);    // round the vestibule
        d = smooth_min(d, ellipsoid(q, {11.4, -37.6, 4.0}, {5.2, 6.0, 6.6}), 2.2);   // wing
        d = smooth_min(d, chain(q, kColumella), 2.6);
        d = smooth_min(d, chain(q, kRim), 3.2);
        return d;
    }

private:
    // Round the nostril: from the sill over the foot of the wing to the side of the tip.
    static constexpr std::array<Ball, 5> kRim{{{3.0, -45.4, -0.4, 2.1},
                                               {8.2, -43.0, 0.2, 2.6},
                                               {12.0, -41.2, 0.4, 3.1},
                                               {12.0, -39.4, 4.8, 3.5},
                                               {6.8, -38.0, 11.4, 3.7}}};
    static constexpr std::array<Ball, 2> kColumella{{{0, -45.4, 0.0, 2.6}, {0, -40.9, 12.5, 2.9}}};
    Spline height_{{-46, -38, -31, -26, -18, -8, 0, 7, 14, 22, 30}, {17.0, 18.2, 17.6, 16.0, 12.6, 8.0, 4.6, 2.4, 0.9, 0, 0}};
    Spline width_{{-46, -38, -32, -24, -14, -4, 6, 16}, {10.5, 10.2, 9.8, 8.8, 7.8, 7.2, 7.2, 8.5}};
};

}  // namespace

Vec3d nose_offset(const HeadProportions& proportions, double x, double y) {
    if (x > 34 || y < -62 || y > 24) return Vec3d::Zero();
    static const Nose nose;
    // Seen a little from below, and spreading: so that the base and the sides of the wings get their share of the grid.
    const double below = 0.28 * smooth_step(-54, -46, y) * smooth_step(-8, -26, y);
    const Vec3d way(0.5 * smooth_step(9, 17, x) * smooth_step(30, 20, x), -below, 1);
    const auto distance = [&](double s) {
        const Vec3d p = Vec3d(x, y, 0) + s * way;
        const double turned = proportions.nose_tip * smooth_step(4, 19, p.z());
        return nose.distance({p.x() / proportions.nose_width, p.y() - turned, p.z() / proportions.nose}, proportions.nose_bridge);
    };
    double s = 32;
    for (int i = 0; i < 200; ++i) {
        const double d = distance(s);
        s -= 0.8 * d;
        if (std::abs(d) < 1e-6) break;
    }
    return s * way;
}

}  // namespace mien::samples
