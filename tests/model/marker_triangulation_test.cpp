#include "encoder/marker_triangulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

namespace mien::encoder {
namespace {

/// Columns around a head of 80 mm radius, rows up and down.
Points bent_grid(int columns, int rows, float jitter = 0, unsigned seed = 0) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> wobble(-jitter, jitter);
    Points points(columns * rows, 3);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const float angle = (float(x) - float(columns - 1) / 2) * 0.12f + wobble(random) / 80;
            points.row(y * columns + x) << 80 * std::sin(angle), 9 * float(y) + wobble(random), 80 * std::cos(angle);
        }
    return points;
}

void expect_complete(const Points& points, const std::vector<Triangle>& triangles, int rim) {
    const int N = int(points.rows());
    EXPECT_EQ(int(triangles.size()), 2 * N - 2 - rim) << "Euler: a disc of N points, rim of them around";
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    std::set<std::uint32_t> used;
    for (const Triangle& t : triangles) {
        const Vec3 a = points.row(t[0]), b = points.row(t[1]), c = points.row(t[2]), middle = (a + b + c) / 3;
        EXPECT_GT((b - a).cross(c - a).dot(Vec3(middle.x(), 0, middle.z())), 0) << "wound outward";
        for (int i = 0; i < 3; ++i) {
            ++edges[{t[i], t[(i + 1) % 3]}];
            used.insert(t[i]);
        }
    }
    EXPECT_EQ(int(used.size()), N);
    int open = 0;
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1) << "each side of an edge belongs to one triangle";
        open += !edges.contains({edge.second, edge.first});
    }
    EXPECT_EQ(open, rim);
}

TEST(MarkerTriangulation, CoversAGridCompletelyAndIsWoundOutward) {
    expect_complete(bent_grid(13, 14), triangulate_markers(bent_grid(13, 14)), 2 * 13 + 2 * 14 - 4);
    expect_complete(bent_grid(2, 2), triangulate_markers(bent_grid(2, 2)), 4);
}

TEST(MarkerTriangulation, TakesScatteredMarkers) {
    for (unsigned seed = 1; seed < 6; ++seed) {
        const Points points = bent_grid(11, 12, 3, seed);
        const auto triangles = triangulate_markers(points);
        std::set<std::uint32_t> used;
        for (const Triangle& t : triangles) used.insert(t.begin(), t.end());
        EXPECT_EQ(used.size(), 132u);
        EXPECT_GE(triangles.size(), 2u * 132 - 2 - 42 - 4);
        EXPECT_LE(triangles.size(), 2u * 132 - 5);
    }
}

TEST(MarkerTriangulation, LeavesGapsOpenAndTakesTooFewOrEqualMarkers) {
    Points two_groups = bent_grid(4, 20);
    two_groups.bottomRows(40).col(1).array() += 200;
    for (const Triangle& t : triangulate_markers(two_groups)) EXPECT_EQ(t[0] < 40, t[2] < 40) << "across the gap";
    EXPECT_TRUE(triangulate_markers(Points(0, 3)).empty());
    EXPECT_TRUE(triangulate_markers(Points::Zero(2, 3)).empty());
    EXPECT_TRUE(triangulate_markers(Points::Zero(9, 3)).empty());
    Points doubled(8, 3);
    doubled << bent_grid(2, 2), bent_grid(2, 2);
    EXPECT_EQ(triangulate_markers(doubled).size(), 2u);
}

}  // namespace
}  // namespace mien::encoder
