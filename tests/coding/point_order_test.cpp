#include "coding/point_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::coding {
namespace {

std::vector<Triangle> grid(std::uint32_t side) {
    std::vector<Triangle> triangles;
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            triangles.push_back({a, a + 1, a + side});
            triangles.push_back({a + 1, a + side + 1, a + side});
        }
    return triangles;
}

void expect_valid(const PointOrder& order, std::uint32_t points) {
    std::vector<std::uint32_t> sorted = order.order;
    std::sort(sorted.begin(), sorted.end());
    ASSERT_EQ(sorted.size(), points);
    for (std::uint32_t i = 0; i < points; ++i) ASSERT_EQ(sorted[i], i);
    std::vector<std::uint32_t> position(points);
    for (std::uint32_t i = 0; i < points; ++i) position[order.order[i]] = i;
    for (std::uint32_t i = 0; i < points; ++i)
        for (const auto& reference : order.of(i)) {
            ASSERT_LT(position[reference.point], i);
            ASSERT_GT(reference.weight, 0);
        }
}

TEST(PointOrder, MeshPointsReferToEarlierPointsOnly) {
    const PointOrder order = mesh_order(400, grid(20));
    expect_valid(order, 400);
    std::size_t alone = 0;
    for (std::size_t i = 0; i < 400; ++i) alone += order.of(i).empty();
    EXPECT_LE(alone, 4u);
    EXPECT_GT(order.level.front(), order.level.back());
    EXPECT_EQ(order.level.back(), 0);
}

TEST(PointOrder, TakesLoosePointsHubsAndNonsenseTriangles) {
    expect_valid(mesh_order(1, {}), 1);
    std::vector<Triangle> fan;
    for (std::uint32_t i = 1; i + 1 < 3000; ++i) fan.push_back({0, i, i + 1});
    expect_valid(mesh_order(3000, fan), 3000);
    const std::vector<Triangle> nonsense{{0, 0, 0}, {1, 2, 99}, {3, 1, 3}};
    expect_valid(mesh_order(5, nonsense), 5);
}

TEST(PointOrder, PartnersFollowEachOtherAndLookAtMirroredReferences) {
    constexpr std::uint32_t kSide = 20;
    std::vector<std::uint32_t> mirror(kSide * kSide);
    for (std::uint32_t v = 0; v < mirror.size(); ++v) mirror[v] = v / kSide * kSide + kSide - 1 - v % kSide;
    const PointOrder order = mesh_order(kSide * kSide, grid(kSide), mirror);
    expect_valid(order, kSide * kSide);
    ASSERT_EQ(order.partner.size(), order.order.size());
    std::size_t mirrored = 0;
    for (std::size_t i = 0; i < order.order.size(); i += 2) {
        EXPECT_EQ(order.partner[i], order.order[i]) << "the first of a pair has none yet";
        ASSERT_EQ(order.order[i + 1], mirror[order.order[i]]);
        ASSERT_EQ(order.partner[i + 1], order.order[i]);
        bool same = order.of(i).size() == order.of(i + 1).size();
        for (std::size_t r = 0; same && r < order.of(i).size(); ++r) same = order.of(i + 1)[r].point == mirror[order.of(i)[r].point];
        mirrored += same;
    }
    EXPECT_EQ(mirrored, order.order.size() / 2);
    const PointOrder plain = mesh_order(kSide * kSide, grid(kSide));
    EXPECT_EQ(plain.partner, plain.order);
}

TEST(PointOrder, ParentsAreTakenAsGiven) {
    const std::vector<std::uint32_t> parents{0, 0, 2, 1};
    const PointOrder order = parent_order(parents);
    expect_valid(order, 4);
    EXPECT_TRUE(order.of(0).empty());
    EXPECT_EQ(order.of(1).front().point, 0u);
    EXPECT_TRUE(order.of(2).empty());
    EXPECT_EQ(order.of(3).front().point, 1u);
}

}  // namespace
}  // namespace mien::coding
