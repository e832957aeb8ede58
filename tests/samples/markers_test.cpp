#include "samples/markers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "flat_actor.hpp"

namespace mien::samples {
namespace {

TEST(Markers, AreAsManyAsAskedForDistinctAndOnTheFace) {
    const FlatActor actor;
    for (int count : {1, 40, kMarkerCount, 400}) {
        const auto sites = place_markers(actor, count);
        ASSERT_EQ(sites.size(), std::size_t(count));
        std::set<std::uint32_t> vertices;
        for (const Site& site : sites) {
            vertices.insert(site.vertices[0]);
            const Vec3 p = site.position(actor.neutral().positions);
            EXPECT_GT(p.y(), actor.landmarks().chin.y() - 25);
            EXPECT_LT(std::abs(p.x()), 85);
            EXPECT_FALSE(std::abs(p.y() - 35) < 2 && std::abs(std::abs(p.x()) - 32) < 8) << "in the opening of an eye";
        }
        EXPECT_EQ(vertices.size(), std::size_t(count));
    }
}

TEST(Markers, LineTheLipsAboveAndBelow) {
    const FlatActor actor;
    int above = 0, below = 0;
    for (const Site& site : place_markers(actor)) {
        const Vec3 p = site.position(actor.neutral().positions);
        if (std::abs(p.x()) > 22 || std::abs(p.y() + 35) > 14) continue;
        ++(p.y() > -35 ? above : below);
    }
    EXPECT_GE(above, 7);
    EXPECT_GE(below, 7);
}

TEST(Markers, FollowTheSeed) {
    const FlatActor actor;
    const auto vertices = [&](std::uint64_t seed) {
        std::vector<std::uint32_t> list;
        for (const Site& site : place_markers(actor, 100, seed)) list.push_back(site.vertices[0]);
        return list;
    };
    EXPECT_EQ(vertices(4), vertices(4));
    EXPECT_NE(vertices(4), vertices(5));
}

TEST(MarkerFaults, NoiseHasTheSpreadAskedFor) {
    PointSequence markers(300, 50);
    add_faults(markers, {0.2, 0}, {30, 1}, 9);
    double sum = 0, squares = 0;
    for (float x : markers.xyz) sum += x, squares += double(x) * x;
    const double n = double(markers.xyz.size());
    EXPECT_NEAR(sum / n, 0, 0.004);
    EXPECT_NEAR(std::sqrt(squares / n), 0.2, 0.004);
    PointSequence again(300, 50);
    add_faults(again, {0.2, 0}, {30, 1}, 9);
    EXPECT_EQ(markers.xyz, again.xyz);
}

TEST(MarkerFaults, LostSamplesComeInGapsOfTheShareAskedFor) {
    for (double share : {0.05, 0.3}) {
        PointSequence markers(600, 100);
        add_faults(markers, {0, share}, {60, 1}, 2);
        int lost = 0, gaps = 0;
        for (std::int64_t m = 0; m < 100; ++m)
            for (std::int64_t f = 0; f < 600; ++f) {
                const bool gone = std::isnan(markers.frame(f)(m, 0));
                EXPECT_EQ(gone, bool(std::isnan(markers.frame(f)(m, 2))));
                lost += gone;
                gaps += gone && (f == 0 || !std::isnan(markers.frame(f - 1)(m, 0)));
            }
        EXPECT_NEAR(lost / 60000.0, share, 0.25 * share);
        EXPECT_NEAR(double(lost) / gaps, 9, 2.0) << "0.15 s at 60 Hz";
    }
}

}  // namespace
}  // namespace mien::samples
