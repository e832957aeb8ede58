#include "samples/occlusion.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::samples {
namespace {

constexpr float kEndless = 1e9f;  // mm of reach: every blocker shades fully

// A ball of radius 100 mm, triangles outward.
Mesh ball() {
    constexpr int kRows = 24, kColumns = 48;
    Mesh mesh;
    mesh.positions.resize(kRows * kColumns + 2, 3);
    for (int r = 0; r < kRows; ++r)
        for (int c = 0; c < kColumns; ++c) {
            const float theta = 3.14159265f * float(r + 1) / (kRows + 1),
                        phi = 6.2831853f * float(c) / kColumns;
            mesh.positions.row(r * kColumns + c) << 100 * std::sin(theta) * std::cos(phi),
                100 * std::cos(theta), -100 * std::sin(theta) * std::sin(phi);
        }
    const std::uint32_t top = kRows * kColumns, bottom = top + 1;
    mesh.positions.row(top) << 0, 100, 0;
    mesh.positions.row(bottom) << 0, -100, 0;
    const auto at = [](int r, int c) { return std::uint32_t(r * kColumns + c % kColumns); };
    for (int c = 0; c < kColumns; ++c) {
        mesh.triangles.push_back({top, at(0, c), at(0, c + 1)});
        mesh.triangles.push_back({bottom, at(kRows - 1, c + 1), at(kRows - 1, c)});
        for (int r = 0; r + 1 < kRows; ++r) {
            mesh.triangles.push_back({at(r, c), at(r + 1, c), at(r + 1, c + 1)});
            mesh.triangles.push_back({at(r, c), at(r + 1, c + 1), at(r, c + 1)});
        }
    }
    return mesh;
}

TEST(Occlusion, ABallSeesTheWholeSkyAboveEveryPoint) {
    const Mesh mesh = ball();
    const Points normals = vertex_normals(mesh.positions, mesh.triangles);
    ASSERT_GT(normals.row(0).dot(mesh.positions.row(0)), 0);
    const Eigen::VectorXf open =
        Occlusion(mesh.positions, mesh.triangles).at(mesh.positions, normals, kEndless);
    EXPECT_GT(open.minCoeff(), 0.97f);
}

TEST(Occlusion, TheInsideOfABallIsDark) {
    const Mesh mesh = ball();
    const Points inward = -vertex_normals(mesh.positions, mesh.triangles);
    const Eigen::VectorXf open =
        Occlusion(mesh.positions, mesh.triangles).at(mesh.positions, inward, kEndless);
    EXPECT_LT(open.maxCoeff(), 0.05f);
}

TEST(Occlusion, FarBlockersShadeLess) {
    const Mesh mesh = ball();
    const Points inward = -vertex_normals(mesh.positions, mesh.triangles);
    const Occlusion occlusion(mesh.positions, mesh.triangles);
    const float near = occlusion.at(mesh.positions, inward, 1000).mean(),
                far = occlusion.at(mesh.positions, inward, 20).mean();
    EXPECT_LT(near, 0.25f);
    EXPECT_GT(far, 0.75f);
}

// A wide wall of height H at distance z takes (1 - z / sqrt(z^2 + H^2)) / 2 of a floor's cosine-weighted sky.
TEST(Occlusion, AWallTakesTheShareOfTheSkyThatGeometryTells) {
    Mesh mesh;
    mesh.positions.resize(10, 3);
    constexpr float kFar = 100;
    mesh.positions << -kFar, 0, 0, kFar, 0, 0, kFar, 0, kFar, -kFar, 0, kFar,  // floor: z >= 0
        -kFar, 0, 0, kFar, 0, 0, kFar, kFar, 0, -kFar, kFar, 0,                // wall: z = 0
        0, 0, 10,                                                              // near the foot
        0, 0, 98;                                                              // far out
    mesh.triangles = {{0, 3, 2}, {0, 2, 1}, {4, 5, 6}, {4, 6, 7}};
    Points normals = Points::Zero(10, 3);
    normals.row(8) << 0, 1, 0;
    normals.row(9) << 0, 1, 0;
    const Eigen::VectorXf open =
        Occlusion(mesh.positions, mesh.triangles, 150).at(mesh.positions, normals, kEndless);
    EXPECT_NEAR(open[8], 1 - 0.5f * (1 - 10 / std::hypot(10.0f, 100.0f)), 0.05f);
    EXPECT_NEAR(open[9], 1 - 0.5f * (1 - 98 / std::hypot(98.0f, 100.0f)), 0.06f);
    EXPECT_EQ(open[0], 1.0f);  // no normal, no sky to lose
}

}  // namespace
}  // namespace mien::samples
