#include "core/geometry.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/texel_map.hpp"

namespace mien {
namespace {

TEST(FitRigid, FindsTheMotionThatWasApplied) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal(0, 50);
    Points from(20, 3);
    for (auto& x : from.reshaped()) x = normal(random);
    const RigidPose truth{Eigen::Quaternionf(Eigen::AngleAxisf(0.7f, Vec3(1, 2, -1).normalized())), Vec3(10, -20, 5)};
    Points to = from;
    apply_pose(truth, to);
    const RigidPose found = fit_rigid(from, to);
    EXPECT_LT(found.rotation.angularDistance(truth.rotation), 1e-4f);
    EXPECT_LT((found.translation - truth.translation).norm(), 1e-2f);

    // A mirrored cloud has no rotation that fits; the answer must still be a rotation.
    to.col(0) *= -1;
    EXPECT_NEAR(fit_rigid(from, to).rotation.toRotationMatrix().determinant(), 1, 1e-4);
}

TEST(TexelMap, CoversASquareWithoutGaps) {
    Mesh mesh;
    mesh.positions = Points::Zero(4, 3);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.texcoords = {{0.25f, 0.25f}, {0.75f, 0.25f}, {0.75f, 0.75f}, {0.25f, 0.75f}};
    mesh.texcoord_triangles = mesh.triangles;
    const TexelMap map = make_texel_map(mesh, 16, 16);
    int used = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            EXPECT_EQ(map.used(x, y), x >= 4 && x < 12 && y >= 4 && y < 12) << x << ' ' << y;
            used += map.used(x, y);
        }
    EXPECT_EQ(used, 64);
}

}  // namespace
}  // namespace mien
