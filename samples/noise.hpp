#pragma once

#include <cstdint>

#include "core/geometry.hpp"

/// Repeatable randomness for things drawn by code. Everything is a pure function of its arguments.
namespace mien::samples {

/// A well-mixed 32-bit hash of a lattice point.
std::uint32_t lattice_hash(int x, int y, int z, std::uint32_t seed);

/// Gradient noise (Perlin 2002) in about [-1, 1], mean 0, features of size 1. The seed picks the gradients.
float gradient_noise(const Vec3& p, std::uint32_t seed);

/// Sum of `octaves` gradient noises, each of half the size and `gain` times the height of the one before;
/// about [-1, 1].
float fractal_noise(const Vec3& p, int octaves, std::uint32_t seed, float gain = 0.5f);

/// Cellular noise (Worley 1996): one random site in every unit cell.
struct Cellular {
    float nearest;     ///< distance to the nearest site
    float second;      ///< distance to the second nearest
    std::uint32_t id;  ///< of the nearest site, random bits
};
Cellular cellular_noise(const Vec3& p, std::uint32_t seed);

/// SplitMix64 (Steele et al. 2014): the same numbers on every machine, unlike the distributions of <random>.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t bits();
    float uniform() { return float(bits() >> 40) * 0x1p-24f; }  ///< [0, 1)
    float uniform(float low, float high) { return low + (high - low) * uniform(); }
    float normal();  ///< mean 0, standard deviation 1

private:
    std::uint64_t state_;
};

/// 0 below `low`, 1 above `high`, a smooth cubic between; low > high makes it fall.
inline float smooth_step(float low, float high, float x) {
    const float t = std::min(1.0f, std::max(0.0f, (x - low) / (high - low)));
    return t * t * (3 - 2 * t);
}

}  // namespace mien::samples
