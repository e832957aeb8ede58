#include <gtest/gtest.h>

#include <map>
#include <set>

#include "samples/procedural_actor.hpp"

namespace mien::samples {
namespace {

const Actor& plain_actor() {
    static const std::unique_ptr<Actor> actor = make_procedural_actor();
    return *actor;
}

TEST(HeadMesh, has_enough_vertices_and_one_coordinate_triangle_per_triangle) {
    const Mesh& mesh = plain_actor().neutral();
    EXPECT_GE(mesh.vertex_count(), 9000u);
    EXPECT_LE(mesh.vertex_count(), 15000u);
    ASSERT_EQ(mesh.triangles.size(), mesh.texcoord_triangles.size());
    std::set<std::uint32_t> used;
    for (const Triangle& t : mesh.triangles) used.insert(t.begin(), t.end());
    EXPECT_EQ(used.size(), mesh.vertex_count()) << "every vertex belongs to a triangle";
}

TEST(HeadMesh, edges_are_manifold_and_open_only_at_the_neck_under_the_lids_behind_the_eyes_and_at_the_gums) {
    const Mesh& mesh = plain_actor().neutral();
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    for (const Triangle& t : mesh.triangles)
        for (int c = 0; c < 3; ++c) ++directed[{t[c], t[(c + 1) % 3]}];
    std::map<std::uint32_t, std::uint32_t> next;
    for (const auto& [edge, count] : directed) {
        ASSERT_EQ(count, 1) << "edge " << edge.first << "-" << edge.second << " is used twice in one direction";
        if (!directed.contains({edge.second, edge.first})) {
            ASSERT_FALSE(next.contains(edge.second)) << "two borders meet in vertex " << edge.second;
            next[edge.second] = edge.first;
        }
    }
    int loops = 0;
    while (!next.empty()) {
        const std::uint32_t start = next.begin()->first;
        for (std::uint32_t v = start; next.contains(v);) {
            const std::uint32_t following = next[v];
            next.erase(v);
            v = following;
        }
        ++loops;
    }
    EXPECT_EQ(loops, 1 + 2 + 2 + 2);
}

}  // namespace
}  // namespace mien::samples
