#include <algorithm>
#include <cmath>

#include "samples/skin_paint.hpp"

namespace mien::samples {

Pigment Painter::eyeball(const Vec3& p, float footprint) const {
    const Landmarks& marks = places_.marks();
    const int side = Places::side_of(p);
    const Vec3 q = p - marks.eye_centre[side];
    const float off_axis = q.head<2>().norm(), r = q.z() > 0 ? off_axis / places_.iris_radius() : 9.0f;
    const float angle = std::atan2(q.y(), q.x());
    const std::uint32_t seed = seed_ + 71 + std::uint32_t(side);

    // Sclera: warm white, pinker and veined toward the corners, greyer round the iris.
    const float far = smooth_step(1.05f, 2.3f, r);
    Vec3 sclera = blend(Vec3(0.77f, 0.75f, 0.725f), Vec3(0.60f, 0.46f, 0.41f), 0.75f * far);
    const Vec3 vein_at = Vec3(q.x() * 0.32f, q.y() * 0.75f, q.z() * 0.32f);
    const float wander = fractal_noise(vein_at * 1.1f, 3, seed);
    const float vein = bump(wander, 0.028f + 0.02f * footprint) *
                       smooth_step(-0.15f, 0.3f, fractal_noise(q * 0.21f, 2, seed + 5));
    sclera = blend(sclera, Vec3(0.55f, 0.20f, 0.17f), 0.42f * vein * smooth_step(1.15f, 2.0f, r));
    sclera *= 1 - 0.16f * smooth_step(1.4f, 1.0f, r);

    // Iris: fibres from the pupil outward, paler and warmer inside the collarette, a dark ring at the limbus.
    const Vec3 round(std::cos(angle), std::sin(angle), 0);
    const auto fibres = [&](float density, std::uint32_t kind) {
        return fractal_noise(round * density + Vec3(0, 0, 1.6f * r), 3, seed + kind, 0.6f);
    };
    const float collarette = 0.50f + 0.06f * fibres(2.2f, 11);
    const float fibre = fibres(7.5f, 12), threads = fibres(16, 13);
    Vec3 iris = complexion_.iris * (1 + 0.75f * fibre + 0.45f * threads);
    const Vec3 amber(0.30f, 0.17f, 0.065f);
    iris = blend(iris, amber * (1 + 0.6f * threads),
                 0.55f * smooth_step(collarette + 0.10f, collarette - 0.10f, r));
    iris *= 1 + 0.55f * bump(r - collarette, 0.07f) - 0.35f * smooth_step(0.62f, 0.92f, r);
    iris *= 1 - 0.55f * smooth_step(0.10f, 0.30f, -fibres(3.4f, 14)) * bump(r - 0.68f, 0.2f);
    iris = blend(iris.cwiseMax(0.004f), Vec3(0.018f, 0.020f, 0.022f), 0.82f * smooth_step(0.80f, 0.99f, r));
    const float blur = 0.04f + 0.5f * footprint / places_.iris_radius();
    iris = blend(Vec3(0.0035f, 0.003f, 0.003f), iris, smooth_step(0.345f - blur, 0.345f + blur, r));

    const float limbus = 0.07f + 0.5f * footprint / places_.iris_radius();
    return {blend(iris, sclera, smooth_step(1 - limbus, 1 + 1.2f * limbus, r))};
}

Pigment Painter::tooth(const Vec3& p) const {
    const float s = places_.scale();
    // Teeth lie on an arch, so the bearing from its middle tells one from the next: canines are yellower.
    const Vec3 hinge = places_.mouth_centre() - Vec3(0, 0, 42 * s);
    const float bearing = std::atan2(p.x() - hinge.x(), p.z() - hinge.z());
    const bool upper = p.y() > teeth_middle_;
    const float tooth_number = std::floor(std::abs(bearing) / 0.19f);
    const auto hash = lattice_hash(int(tooth_number), bearing > 0, upper, seed_ + 81);
    const float odd = float(hash & 255) / 255 - 0.5f;
    const float canine = bump(std::abs(bearing) - 0.47f, 0.12f),
                back = smooth_step(0.5f, 1.1f, std::abs(bearing));
    Vec3 enamel = Vec3(0.72f, 0.665f, 0.585f) * (1 + 0.05f * odd);
    enamel = enamel.cwiseProduct(blend(Vec3::Ones(), Vec3(0.96f, 0.92f, 0.83f), 0.7f * canine + 0.4f * back));
    const float to_gum = std::abs(p.y() - teeth_middle_) / std::max(1.0f, (teeth_high_ - teeth_low_) / 2);
    enamel = enamel.cwiseProduct(
        blend(Vec3::Ones(), Vec3(0.95f, 0.87f, 0.76f), smooth_step(0.35f, 0.85f, to_gum)));
    enamel = enamel.cwiseProduct(
        blend(Vec3::Ones(), Vec3(0.91f, 0.92f, 0.94f), smooth_step(0.16f, 0.04f, to_gum)));
    enamel *= 1 + 0.03f * fractal_noise(Vec3(p.x() / 1.4f, p.y() / 6, p.z() / 1.4f) / s, 2, seed_ + 82);
    // What light comes in so far has been on gums and tongue before.
    const Vec3 warmed = blend(Vec3::Ones(), Vec3(0.66f, 0.50f, 0.44f), smooth_step(4, 36, places_.behind_lips(p)));
    return {enamel.cwiseProduct(warmed)};
}

Pigment Painter::mouth(const Vec3& p, const Vec3& normal) const {
    const Vec3 q = p / places_.scale();
    const float depth = places_.behind_lips(p);
    Vec3 flesh(0.54f, 0.21f, 0.19f);
    flesh *= 1 + 0.14f * fractal_noise(q / 5, 3, seed_ + 91) + 0.20f * normal.y() +
             0.05f * gradient_noise(q / 0.9f, seed_ + 92);
    flesh = flesh.cwiseProduct(blend(Vec3::Ones(), Vec3(0.48f, 0.30f, 0.30f), smooth_step(8, 50, depth)));
    return {flesh, 0.2f};
}

Vec3 Painter::hair(const Vec3& p, const Vec3& normal) const {
    const Vec3 q = p / places_.scale();
    const Vec3 flow = hair_flow(p, normal), across = normal.cross(flow);
    const Vec3 combed(q.dot(across) / 0.9f, q.dot(flow) / 14, q.dot(normal) / 4);
    return complexion_.hair *
           (0.95f + 0.35f * fractal_noise(combed, 3, seed_ + 95) + 0.2f * fractal_noise(q / 16, 2, seed_ + 96));
}

}  // namespace mien::samples
