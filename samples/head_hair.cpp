#include "samples/head_mesh.hpp"
#include "samples/noise.hpp"
#include "samples/skin_places.hpp"

namespace mien::samples {

double hair_lift(const Vec3d& p) {
    // Middle of the plain head's ears, and where its landmarks lie over it.
    const Vec3d middle(0, -16.3, -24);
    const Vec3 q = (p - middle).cast<float>();
    const double inside = into_scalp(q, Vec3(std::copysign(73.3f, q.x()), 0, 0), 35.3f, -85.7f);
    if (inside <= 0) return 0;
    const double x = p.x(), y = p.y(), z = p.z();
    // Short at the sides and in the nape, long on top, fullest over the forehead.
    const double top = smooth_step(38, 92, y), front = smooth_step(-10, 55, z);
    double thick = mix(mix(2.2, 6.0, smooth_step(-45, 25, y)), 10.0 + 4.5 * front, top);
    thick *= 1 - 0.5 * top * front * bell(x, 30 - 0.05 * (55 - z), 4.5);  // the parting
    thick *= 1 + 0.10 * top * front * std::tanh((24 - x) / 10);
    // Locks: noise drawn out along the way they are combed.
    const Vec3 lock(float((z + 0.25 * x) / 11), float(y / 26), float((x + 0.3 * y) / 40));
    thick *= 1 + 0.24 * top * fractal_noise(lock, 2, 4711) + 0.10 * fractal_noise((p / 9).cast<float>(), 1, 4712);
    // It rises from the scalp over the forehead, where an edge would look like a cap's brim.
    return std::max(thick, 1.0) * smooth_step(0, mix(12, 30, front), inside);
}

}  // namespace mien::samples
