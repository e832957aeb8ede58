#include "coding/mirror_code.hpp"

#include <gtest/gtest.h>

#include <random>

namespace mien::coding {
namespace {

/// Left and right of an odd side are built as mirrors of each other.
std::vector<Triangle> grid(std::uint32_t side) {
    std::vector<Triangle> triangles;
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            const bool left = 2 * x < side - 1;
            triangles.push_back({a, a + 1, left ? a + side : a + side + 1});
            triangles.push_back({left ? a + 1 : a, a + side + 1, a + side});
        }
    return triangles;
}

std::vector<std::uint32_t> mirror_of_grid(std::uint32_t side) {
    std::vector<std::uint32_t> mirror(side * side);
    for (std::uint32_t v = 0; v < mirror.size(); ++v) mirror[v] = v / side * side + side - 1 - v % side;
    return mirror;
}

Bytes write(const std::vector<std::vector<std::uint32_t>>& neighbours, std::vector<std::uint32_t> mirror) {
    RangeEncoder coder;
    code_mirror(coder, neighbours, mirror);
    return coder.finish();
}

TEST(MirrorCode, ComesBackAndCostsLittleOnAMeshBuiltSymmetrically) {
    const std::uint32_t side = 61;
    const auto neighbours = vertex_neighbours(side * side, grid(side));
    const auto mirror = mirror_of_grid(side);
    const Bytes bytes = write(neighbours, mirror);
    EXPECT_LT(8.0 * double(bytes.size()), 0.2 * double(mirror.size()));
    std::vector<std::uint32_t> back;
    RangeDecoder coder(bytes);
    code_mirror(coder, neighbours, back);
    EXPECT_TRUE(coder.complete());
    EXPECT_EQ(back, mirror);
}

TEST(MirrorCode, KeepsAnyInvolution) {
    std::mt19937 random(3);
    for (int round = 0; round < 20; ++round) {
        const std::uint32_t V = 1 + std::uint32_t(random() % 120);
        std::vector<Triangle> triangles;
        for (std::uint32_t i = 0; i < V; ++i)
            triangles.push_back({std::uint32_t(random() % V), std::uint32_t(random() % V), std::uint32_t(random() % V)});
        std::vector<std::uint32_t> mirror(V);
        for (std::uint32_t v = 0; v < V; ++v) mirror[v] = v;
        for (std::uint32_t i = 0; i < V / 2; ++i) {
            const std::uint32_t a = std::uint32_t(random() % V), b = std::uint32_t(random() % V);
            if (mirror[a] == a && mirror[b] == b) std::swap(mirror[a], mirror[b]);
        }
        const auto neighbours = vertex_neighbours(V, triangles);
        std::vector<std::uint32_t> back;
        const Bytes bytes = write(neighbours, mirror);
        RangeDecoder coder(bytes);
        code_mirror(coder, neighbours, back);
        EXPECT_TRUE(coder.complete());
        EXPECT_EQ(back, mirror);
    }
}

TEST(MirrorCode, DamageFailsOrIsStillAnInvolution) {
    const std::uint32_t side = 9;
    const auto neighbours = vertex_neighbours(side * side, grid(side));
    const Bytes good = write(neighbours, mirror_of_grid(side));
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] ^= std::byte(1u << bit % 8);
        std::vector<std::uint32_t> back;
        RangeDecoder coder(bytes);
        code_mirror(coder, neighbours, back);
        if (coder.failed()) continue;
        ASSERT_EQ(back.size(), side * side);
        for (std::uint32_t v = 0; v < back.size(); ++v) ASSERT_EQ(back[back[v]], v);
    }
}

}  // namespace
}  // namespace mien::coding
