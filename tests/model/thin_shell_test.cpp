#include "model/thin_shell.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::model {
namespace {

/// A flat sheet of side x side vertices, `spacing` mm apart.
Mesh sheet(std::uint32_t side, float spacing) {
    Mesh mesh;
    mesh.positions.resize(side * side, 3);
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) mesh.positions.row(y * side + x) << spacing * float(x), spacing * float(y), 0;
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x, b = a + 1, c = a + side, d = c + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    return mesh;
}

TEST(MeshLaplacian, IsTheFivePointStencilOnASquareGridAndKnowsAreas) {
    const Mesh mesh = sheet(5, 2);
    const MeshLaplacian laplacian = mesh_laplacian(mesh.positions, mesh.triangles);
    EXPECT_NEAR(laplacian.area.sum(), 64, 1e-9);
    EXPECT_NEAR(laplacian.area[12], 4, 1e-9);
    Eigen::VectorXd f(25);
    for (int v = 0; v < 25; ++v) f[v] = std::pow(double(mesh.positions(v, 0)), 2) + 3 * mesh.positions(v, 1);
    const Eigen::VectorXd minus_laplace = laplacian.stiffness * f;
    for (const int v : {6, 7, 8, 11, 12, 13, 16, 17, 18}) EXPECT_NEAR(-minus_laplace[v] / laplacian.area[v], 2, 1e-6) << "of x^2 + 3 y";
}

TEST(ThinShell, MarkersAreMetExactlyAndRigidShiftsStayRigid) {
    const Mesh mesh = sheet(12, 3);
    std::vector<Site> sites = {Site::at_vertex(13), Site::at_vertex(100), {{40, 41, 53}, {0.2f, 0.5f, 0.3f}}, Site::at_vertex(130)};
    const Eigen::MatrixXf R = thin_shell_response(mesh, sites, {});
    for (int m = 0; m < 4; ++m)
        for (int k = 0; k < 4; ++k) {
            float at = 0;
            for (int i = 0; i < 3; ++i) at += sites[std::size_t(m)].weights[i] * R(sites[std::size_t(m)].vertices[i], k);
            EXPECT_NEAR(at, m == k ? 1 : 0, 1e-5f);
        }
    EXPECT_LT((R.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-4f) << "nothing is fixed, so a common shift moves all alike";
}

TEST(ThinShell, ABentStripFollowsTheBeamThatItIs) {
    // Clamped at two rows at the left, held at the right: with pure bending and the Laplacian's natural border (no slope across
    // it) this is a beam with a guided end, s^2 (3 - 2 s).
    constexpr std::uint32_t kLength = 41;
    Mesh mesh;
    mesh.positions.resize(3 * kLength, 3);
    for (std::uint32_t x = 0; x < kLength; ++x)
        for (std::uint32_t y = 0; y < 3; ++y) mesh.positions.row(3 * x + y) << float(x), float(y), 0;
    for (std::uint32_t x = 0; x + 1 < kLength; ++x)
        for (std::uint32_t y = 0; y < 2; ++y) {
            const std::uint32_t a = 3 * x + y, b = a + 3, c = a + 1, d = b + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    std::vector<Site> sites;
    for (std::uint32_t y = 0; y < 3; ++y) sites.push_back(Site::at_vertex(3 * (kLength - 1) + y));
    const Eigen::MatrixXf R = thin_shell_response(mesh, sites, {0, 1, 2, 3, 4, 5}, 1, {.stretching = 0, .bending = 1});
    const double l = kLength - 1.5;  // the clamp acts between its two rows
    for (std::uint32_t x = 2; x < kLength; ++x) {
        const double s = (x - 0.5) / l;
        EXPECT_NEAR(R.row(3 * x + 1).sum(), s * s * (3 - 2 * s), 0.005) << x;
    }
}

TEST(ThinShell, FixedVerticesAndOtherPiecesDoNotMove) {
    Mesh mesh = sheet(8, 2);
    const Mesh other = sheet(3, 2);
    const std::uint32_t first = mesh.vertex_count();
    mesh.positions.conservativeResize(first + 9, 3);
    mesh.positions.bottomRows(9) = other.positions.array() + 100;
    for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    const Eigen::MatrixXf R = thin_shell_response(mesh, {Site::at_vertex(27)}, {0, 1, 2, 3, 4, 5, 6, 7});
    EXPECT_EQ(R.topRows(8).cwiseAbs().maxCoeff(), 0);
    EXPECT_EQ(R.bottomRows(9).cwiseAbs().maxCoeff(), 0);
    EXPECT_GT(R(35, 0), 0.5f);
}

TEST(ThinShell, TwoMarkersAtOnePlaceShareIt) {
    const Mesh mesh = sheet(8, 2);
    const Eigen::MatrixXf R = thin_shell_response(mesh, {Site::at_vertex(27), Site::at_vertex(27), Site::at_vertex(60)}, {0});
    ASSERT_TRUE(R.allFinite());
    EXPECT_NEAR(R(27, 0), 0.5f, 1e-3f);
    EXPECT_NEAR(R(27, 1), 0.5f, 1e-3f);
}

}  // namespace
}  // namespace mien::model
