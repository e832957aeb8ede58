#include "samples/skin_strain.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::samples {
namespace {

// A flat square of skin, 21 x 21 vertices, 5 mm apart.
Mesh sheet() {
    constexpr int kSide = 21;
    Mesh mesh;
    mesh.positions.resize(kSide * kSide, 3);
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) mesh.positions.row(y * kSide + x) << 5 * float(x), 5 * float(y), 0;
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
        for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
            const std::uint32_t a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    return mesh;
}

TEST(Strain, IsZeroForRigidMotion) {
    const Mesh mesh = sheet();
    Points moved = mesh.positions;
    apply_pose({Eigen::Quaternionf(Eigen::AngleAxisf(0.7f, Vec3(1, 2, 3).normalized())), Vec3(5, -80, 3)},
               moved);
    const Strain::Field field = Strain(mesh).at(moved);
    EXPECT_LT(field.growth.cwiseAbs().maxCoeff(), 1e-4f);
    EXPECT_LT(field.squeeze.maxCoeff(), 1e-4f);
}

TEST(Strain, TellsTheAreaAndTheDirectionOfEvenStretch) {
    const Mesh mesh = sheet();
    Points moved = mesh.positions;
    moved.col(0) *= 1.2f;
    moved.col(1) *= 0.7f;
    const Strain::Field field = Strain(mesh).at(moved);
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
        EXPECT_NEAR(field.growth[v], std::log(1.2f * 0.7f), 1e-4f);
        EXPECT_NEAR(field.squeeze[v], -std::log(0.7f), 1e-4f);
    }
}

TEST(Strain, StretchAloneSqueezesNothing) {
    const Mesh mesh = sheet();
    const Strain::Field field = Strain(mesh).at(1.3f * mesh.positions);
    EXPECT_GT(field.growth.minCoeff(), 0.5f);
    EXPECT_EQ(field.squeeze.maxCoeff(), 0);
}

TEST(Strain, OnlySkinCounts) {
    Mesh mesh = sheet();
    mesh.parts = {{"plate", Surface::teeth, 0, std::uint32_t(mesh.triangles.size())}};
    const Strain::Field field = Strain(mesh).at(2 * mesh.positions);
    EXPECT_EQ(field.growth.cwiseAbs().maxCoeff(), 0);
}

TEST(Strain, FoldedTrianglesStayFinite) {
    const Mesh mesh = sheet();
    Points moved = mesh.positions;
    moved.topRows(200).setZero();
    const Strain::Field field = Strain(mesh).at(moved);
    EXPECT_TRUE(field.growth.allFinite());
    EXPECT_TRUE(field.squeeze.allFinite());
}

}  // namespace
}  // namespace mien::samples
