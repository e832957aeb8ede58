#include "samples/noise.hpp"

#include <cmath>

namespace mien::samples {
namespace {

float fade(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

// The twelve edge directions of a cube.
constexpr float kEdges[12][3] = {{1, 1, 0},  {1, -1, 0},  {-1, 1, 0}, {-1, -1, 0}, {1, 0, 1},  {1, 0, -1},
                                 {-1, 0, 1}, {-1, 0, -1}, {0, 1, 1},  {0, 1, -1},  {0, -1, 1}, {0, -1, -1}};

// A table and no switch: the direction is as good as random, so a branch would be guessed wrongly most times.
float along_gradient(std::uint32_t hash, float x, float y, float z) {
    const float* edge = kEdges[hash % 12];
    return edge[0] * x + edge[1] * y + edge[2] * z;
}

// Baseline x86-64 rounds down by a function call only.
int floor_of(float value) {
    const int truncated = int(value);
    return truncated - int(value < float(truncated));
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
    const int ix = floor_of(p.x()), iy = floor_of(p.y()), iz = floor_of(p.z());
    const float x = p.x() - float(ix), y = p.y() - float(iy), z = p.z() - float(iz);
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
    const int ix = floor_of(p.x()), iy = floor_of(p.y()), iz = floor_of(p.z());
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
