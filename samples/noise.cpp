#include "samples/noise.hpp"

#include <cmath>

namespace mien::samples {
namespace {

float fade(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

// Dot product of `d` with one of the twelve edge directions of a cube.
float along_gradient(std::uint32_t hash, float x, float y, float z) {
    switch (hash % 12) {
        case 0:
            return x + y;
        case 1:
            return x - y;
        case 2:
            return -x + y;
        case 3:
            return -x - y;
        case 4:
            return x + z;
        case 5:
            return x - z;
        case 6:
            return -x + z;
        case 7:
            return -x - z;
        case 8:
            return y + z;
        case 9:
            return y - z;
        case 10:
            return -y + z;
        default:
            return -y - z;
    }
}

}  // namespace

std::uint32_t lattice_hash(int x, int y, int z, std::uint32_t seed) {
    std::uint32_t h = seed * 0x9e3779b1u + std::uint32_t(x) * 0x85ebca77u + std::uint32_t(y) * 0xc2b2ae3du +
                      std::uint32_t(z) * 0x27d4eb2fu;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return h ^ h >> 15;
}

float gradient_noise(const Vec3& p, std::uint32_t seed) {
    const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
    const int ix = int(fx), iy = int(fy), iz = int(fz);
    const float x = p.x() - fx, y = p.y() - fy, z = p.z() - fz;
    const float u = fade(x), v = fade(y), w = fade(z);
    const auto corner = [&](int i, int j, int k) {
        return along_gradient(lattice_hash(ix + i, iy + j, iz + k, seed), x - float(i), y - float(j),
                              z - float(k));
    };
    const auto edge = [&](int j, int k) {
        const float a = corner(0, j, k), b = corner(1, j, k);
        return a + u * (b - a);
    };
    const auto face = [&](int k) {
        const float a = edge(0, k), b = edge(1, k);
        return a + v * (b - a);
    };
    const float a = face(0), b = face(1);
    return a + w * (b - a);
}

float fractal_noise(const Vec3& p, int octaves, std::uint32_t seed, float gain) {
    float sum = 0, height = 1, heights = 0, frequency = 1;
    for (int i = 0; i < octaves; ++i) {
        sum += height * gradient_noise(p * frequency, seed + std::uint32_t(i) * 101u);
        heights += height;
        height *= gain;
        frequency *= 2.03f;  // not 2: the lattices of two octaves must not line up
    }
    return sum / heights;
}

Cellular cellular_noise(const Vec3& p, std::uint32_t seed) {
    const int ix = int(std::floor(p.x())), iy = int(std::floor(p.y())), iz = int(std::floor(p.z()));
    float nearest = 1e9f, second = 1e9f;
    std::uint32_t id = 0;
    for (int k = -1; k <= 1; ++k)
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) {
                const std::uint32_t h = lattice_hash(ix + i, iy + j, iz + k, seed);
                const Vec3 site(float(ix + i) + float(h & 1023) / 1024,
                                float(iy + j) + float(h >> 10 & 1023) / 1024,
                                float(iz + k) + float(h >> 20 & 1023) / 1024);
                const float distance = (p - site).squaredNorm();
                if (distance < nearest) {
                    second = nearest;
                    nearest = distance;
                    id = h;
                } else if (distance < second) {
                    second = distance;
                }
            }
    return {std::sqrt(nearest), std::sqrt(second), id * 0x9e3779b1u};
}

std::uint64_t Random::bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

float Random::normal() {
    const float radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(6.2831853f * uniform());
}

}  // namespace mien::samples
