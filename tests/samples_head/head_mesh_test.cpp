#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/texel_map.hpp"
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
    EXPECT_LE(mesh.vertex_count(), 17000u);
    ASSERT_EQ(mesh.triangles.size(), mesh.texcoord_triangles.size());
    std::set<std::uint32_t> used;
    for (const Triangle& t : mesh.triangles) used.insert(t.begin(), t.end());
    EXPECT_EQ(used.size(), mesh.vertex_count()) << "every vertex belongs to a triangle";
}

TEST(HeadMesh, edges_are_manifold_and_open_only_at_the_neck_under_the_lids_behind_the_eyes_and_at_the_gums) {
    const Mesh& mesh = plain_actor().neutral();
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (surfaces[i] == Surface::lashes) continue;  // cards
        const Triangle& t = mesh.triangles[i];
        for (int c = 0; c < 3; ++c) ++directed[{t[c], t[(c + 1) % 3]}];
    }
    std::map<std::uint32_t, std::uint32_t> next;
    for (const auto& [edge, count] : directed) {
        ASSERT_EQ(count, 1) << "edge " << edge.first << "-" << edge.second
                            << " is used twice in one direction";
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

double cross(const Vec2& a, const Vec2& b) {
    return double(a.x()) * b.y() - double(a.y()) * b.x();
}

TEST(HeadMesh, texture_triangles_face_up_lie_inside_and_do_not_overlap) {
    for (const std::uint64_t seed : {0, 4}) {
        const auto actor = make_procedural_actor(seed);
        const Mesh& mesh = actor->neutral();
        constexpr int kSize = 2048;
        std::vector<std::uint8_t> taken(std::size_t(kSize) * kSize, 0);
        int overlaps = 0;
        for (const Triangle& t : mesh.texcoord_triangles) {
            const Vec2 a = mesh.texcoords[t[0]], b = mesh.texcoords[t[1]], c = mesh.texcoords[t[2]];
            const double area = cross(b - a, c - a);
            ASSERT_GT(area, 0) << a.transpose();
            for (const Vec2& p : {a, b, c}) {
                ASSERT_GT(p.minCoeff(), 0.004f);
                ASSERT_LT(p.maxCoeff(), 0.996f);
            }
            const Vec2 low = a.cwiseMin(b).cwiseMin(c) * kSize, high = a.cwiseMax(b).cwiseMax(c) * kSize;
            for (int y = int(low.y()); y <= int(high.y()); ++y)
                for (int x = int(low.x()); x <= int(high.x()); ++x) {
                    const Vec2 p((x + 0.5f) / kSize, (y + 0.5f) / kSize);
                    const double inside = 1e-6 * area;  // strictly: neighbours share their edge
                    if (cross(b - a, p - a) <= inside || cross(c - b, p - b) <= inside ||
                        cross(a - c, p - c) <= inside)
                        continue;
                    overlaps += taken[std::size_t(y) * kSize + x]++;
                }
        }
        EXPECT_EQ(overlaps, 0) << "seed " << seed;
    }
}

TEST(HeadMesh, charts_keep_eight_texels_apart) {
    const Mesh& mesh = plain_actor().neutral();
    // Charts: texture coordinates joined by triangles.
    std::vector<std::uint32_t> root(mesh.texcoords.size());
    for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = i;
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    for (const Triangle& t : mesh.texcoord_triangles)
        root[find(t[0])] = find(t[1]), root[find(t[1])] = find(t[2]);
    constexpr int kSize = 1024, kGutter = 8;
    std::vector<std::uint32_t> chart(std::size_t(kSize) * kSize, 0xffffffffu);
    const TexelMap map = make_texel_map(mesh, kSize, kSize);
    for (std::size_t i = 0; i < chart.size(); ++i)
        if (map.texels[i].triangle != TexelMap::kNone)
            chart[i] = find(mesh.texcoord_triangles[map.texels[i].triangle][0]);
    std::set<std::uint32_t> charts;
    int close = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const std::uint32_t own = chart[std::size_t(y) * kSize + x];
            if (own == 0xffffffffu) continue;
            charts.insert(own);
            for (const auto& [dx, dy] : {std::pair{kGutter - 1, 0}, {0, kGutter - 1}, {5, 5}, {5, -5}})
                if (x + dx < kSize && y + dy >= 0 && y + dy < kSize) {
                    const std::uint32_t other = chart[std::size_t(y + dy) * kSize + x + dx];
                    close += other != 0xffffffffu && other != own;
                }
        }
    EXPECT_EQ(close, 0);
    EXPECT_EQ(charts.size(), 1u + 2 + 2 + 1 + 1 + 4) << "skin, eyes, jaws, bag, tongue, lashes";
}

TEST(HeadMesh, the_front_of_the_face_gets_most_of_the_texels) {
    const Mesh& mesh = plain_actor().neutral();
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    double face = 0, all = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& u = mesh.texcoord_triangles[t];
        const double area =
            cross(mesh.texcoords[u[1]] - mesh.texcoords[u[0]], mesh.texcoords[u[2]] - mesh.texcoords[u[0]]) /
            2;
        const Vec3 p = mesh.positions.row(mesh.triangles[t][0]).transpose();
        all += area;
        if (surfaces[t] == Surface::skin && p.z() > 0 && p.y() > -115 && p.y() < 65) face += area;
    }
    EXPECT_GT(all, 0.6);
    EXPECT_GT(face / all, 0.5);
}

// Bounds within which adults' faces lie, mm, wider than any one population's spread. Two rest on published means: between
// the inner corners 31.2 (Middle Eastern), 31.4 SD 2.5 (White) .. 38.5 (African), pooled from 67 studies of 22 638 people
// (PMC9029890); head length of British adults of 19 to 65 years 195 SD 8 (men) and 180 SD 7 (women) (Online Anthropometry,
// City University of Hong Kong, dimension 26). The others say only that this is a face.
TEST(HeadMesh, proportions_are_those_of_people) {
    for (const std::uint64_t seed : {0, 1, 2, 3}) {
        const auto actor = make_procedural_actor(seed);
        const Mesh& mesh = actor->neutral();
        const Landmarks& m = actor->landmarks();
        const auto within = [&](const char* what, double value, double low, double high) {
            EXPECT_GE(value, low) << what << ", seed " << seed;
            EXPECT_LE(value, high) << what << ", seed " << seed;
        };
        within("between the pupils", (m.eye_centre[1] - m.eye_centre[0]).norm(), 56, 70);
        within("between inner corners of the eyes", m.upper_lid[1].front().x() - m.upper_lid[0].front().x(),
               28, 38);
        within("length of the fissure", (m.upper_lid[1].front() - m.upper_lid[1].back()).norm(), 26,
               34);
        within("width of the mouth", m.upper_lip_line.back().x() - m.upper_lip_line.front().x(), 44,
               60);
        const double stomion = m.upper_lip_line[m.upper_lip_line.size() / 2].y();
        within("pupil to mouth", m.eye_centre[0].y() - stomion, 62, 78);
        within("glabella to chin", m.glabella.y() - m.chin.y(), 108, 135);
        within("depth of the nose", m.nose_tip.z() - m.upper_lip_outline[m.upper_lip_outline.size() / 2].z(),
               8, 22);
        // Landmark or not: breadth and length of the head, over the ears; lowest to highest.
        double breadth = 0, front = -1e9, back = 1e9, top = -1e9;
        for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
            const Vec3 p = mesh.positions.row(v).transpose();
            if (p.y() > 30) breadth = std::max(breadth, 2.0 * p.x());
            if (p.y() > 10) front = std::max<double>(front, p.z()), back = std::min<double>(back, p.z());
            top = std::max<double>(top, p.y());
        }
        within("breadth of the head", breadth, 138, 172);  // over the hair
        within("length of the head", front - back, 166, 211);  // 180 - 2 SD .. 195 + 2 SD
        within("pupil to vertex", top - m.eye_centre[0].y(), 98, 125);
        within("radius of the eyeball", m.eye_radius, 11.5, 13);
        EXPECT_LT(mesh.positions.col(1).minCoeff(), -145) << "a neck";
    }
}

}  // namespace
}  // namespace mien::samples
