#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "samples/procedural_actor.hpp"

namespace mien::samples {
namespace {

const Actor& plain_actor() {
    static const std::unique_ptr<Actor> actor = make_procedural_actor();
    return *actor;
}

Instant with(std::initializer_list<std::pair<const char*, float>> weights) {
    Instant instant;
    for (const auto& [name, value] : weights) instant.weights[arkit_index(name)] = value;
    return instant;
}

/// Weights as a lively face has them: about a third of the muscles at work.
Instant random_instant(std::mt19937& random) {
    Instant instant;
    for (float& w : instant.weights) w = random() % 3 == 0 ? float(random() % 1001) / 1000 : 0.f;
    return instant;
}

Vec3 area_vector(const Points& points, const Triangle& t) {
    const Vec3 a = points.row(t[0]), b = points.row(t[1]), c = points.row(t[2]);
    return 0.5f * (b - a).cross(c - a);
}

/// Triangles that face backwards, counted where they have nothing to do with turning eyeballs.
int inverted(const Points& points) {
    const Mesh& mesh = plain_actor().neutral();
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    int count = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (surfaces[t] != Surface::eye)
            count +=
                area_vector(points, mesh.triangles[t]).dot(area_vector(mesh.positions, mesh.triangles[t])) <=
                0;
    return count;
}

std::uint32_t nearest(const Points& points, const Vec3& p) {
    Eigen::Index best = 0;
    (points.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff(&best);
    return static_cast<std::uint32_t>(best);
}

/// Vertices on which a landmark line lies.
std::vector<std::uint32_t> vertices_of(const Landmarks::Line& line) {
    std::vector<std::uint32_t> result;
    for (const Vec3& p : line) result.push_back(nearest(plain_actor().neutral().positions, p));
    return result;
}

TEST(HeadMotion, no_weights_give_the_neutral_head_but_for_nothing) {
    const Points moved = plain_actor().deform({});
    EXPECT_LT((moved - plain_actor().neutral().positions).rowwise().norm().maxCoeff(), 0.05f);
}

TEST(HeadMotion, every_shape_does_something_except_closing_a_closed_mouth_and_stays_within_the_face) {
    const Points& rest = plain_actor().neutral().positions;
    for (int shape = 0; shape < kArkitCount; ++shape) {
        Instant instant;
        instant.weights[shape] = 1;
        const float moved = (plain_actor().deform(instant) - rest).rowwise().norm().maxCoeff();
        if (kArkitNames[shape] == "MouthClose")
            EXPECT_LT(moved, 0.05f);
        else
            EXPECT_GT(moved, 1.0f) << kArkitNames[shape];
        EXPECT_LT(moved, 45.f) << kArkitNames[shape];
    }
}

TEST(HeadMotion, triangles_keep_their_side_and_their_area_in_every_shape) {
    const Mesh& mesh = plain_actor().neutral();
    for (int shape = 0; shape < kArkitCount; ++shape) {
        Instant instant;
        instant.weights[shape] = 1;
        const Points points = plain_actor().deform(instant);
        // A closed lid folds a few triangles of its unseen inner side in the corner of the eye.
        EXPECT_LE(inverted(points), 10) << kArkitNames[shape];
        for (const Triangle& t : mesh.triangles)
            ASSERT_GT(area_vector(points, t).norm(), 0.001f) << kArkitNames[shape];
    }
}

TEST(HeadMotion, triangles_keep_their_side_in_mixtures) {
    std::mt19937 random(7);
    int sum = 0;
    for (int trial = 0; trial < 20; ++trial) {
        const int count = inverted(plain_actor().deform(random_instant(random)));
        EXPECT_LE(count, 30);  // of 28 000
        sum += count;
    }
    EXPECT_LE(sum, 20 * 10);
}

TEST(HeadMotion, lips_never_cross) {
    const std::vector<std::uint32_t> upper = vertices_of(plain_actor().landmarks().upper_lip_line),
                                     lower = vertices_of(plain_actor().landmarks().lower_lip_line);
    ASSERT_EQ(upper.size(), lower.size());
    std::mt19937 random(11);
    std::vector<Instant> instants = {with({}), with({{"MouthShrugLower", 1.f}}),
                                     with({{"JawOpen", 1.f}, {"MouthClose", 1.f}}),
                                     with({{"MouthRollLower", 1.f}, {"MouthRollUpper", 1.f}}),
                                     with({{"MouthPressLeft", 1.f}, {"MouthPressRight", 1.f}})};
    for (int trial = 0; trial < 40; ++trial) instants.push_back(random_instant(random));
    for (const Instant& instant : instants) {
        const Points points = plain_actor().deform(instant);
        for (std::size_t i = 1; i + 1 < upper.size(); ++i)
            ASSERT_GT(points(upper[i], 1) - points(lower[i], 1), 0.02f);
    }
}

/// How many crowns' vertices that look out of the mouth have come through the skin: within 6 mm behind each of those, against
/// its normal, lies the outer side of a lip or cheek.
int teeth_through_skin(const Points& points) {
    const Mesh& mesh = plain_actor().neutral();
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    const Points normals = vertex_normals(points, mesh.triangles);
    std::set<std::uint32_t> crowns;
    std::vector<Triangle> skin;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& c = mesh.triangles[t];
        const Vec3 p = points.row(c[0]).transpose();
        if (surfaces[t] == Surface::teeth) crowns.insert(c.begin(), c.end());
        if (surfaces[t] == Surface::skin && p.z() > 55 && p.y() > -130 && p.y() < -45) skin.push_back(c);
    }
    int count = 0;
    for (const std::uint32_t v : crowns) {
        const Vec3 from = points.row(v).transpose(), in = -normals.row(v).transpose();
        if (in.z() > -0.3f) continue;
        count += std::any_of(skin.begin(), skin.end(), [&](const Triangle& t) {
            const Vec3 a = points.row(t[0]).transpose(), ab = points.row(t[1]).transpose() - a, ac = points.row(t[2]).transpose() - a;
            const float facing = ab.cross(ac).dot(in);   // < 0: the outer side
            if (facing >= 0) return false;
            const Vec3 p = from - a;   // Moeller and Trumbore 1997
            const float u = p.cross(ac).dot(in) / facing, w = ab.cross(p).dot(in) / facing, along = -ab.cross(ac).dot(p) / facing;
            return u >= 0 && w >= 0 && u + w <= 1 && along > 0 && along < 6;
        });
    }
    return count;
}

TEST(HeadMotion, no_tooth_comes_through_a_lip) {
    std::vector<Instant> instants = {with({}), with({{"MouthRollLower", 1.f}, {"MouthRollUpper", 1.f}}),
                                     with({{"MouthPressLeft", 1.f}, {"MouthPressRight", 1.f}}),
                                     with({{"MouthSmileLeft", 1.f}, {"MouthSmileRight", 1.f}}),
                                     with({{"MouthLowerDownLeft", 1.f}, {"MouthUpperUpRight", 1.f}, {"JawOpen", 0.2f}})};
    for (const float open : {0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.f}) {
        instants.push_back(with({{"JawOpen", open}}));
        instants.push_back(with({{"JawOpen", open}, {"MouthClose", open}}));
        instants.push_back(with({{"JawOpen", open}, {"MouthSmileLeft", 0.8f}, {"MouthSmileRight", 0.8f}}));
    }
    for (std::size_t i = 0; i < instants.size(); ++i)
        EXPECT_EQ(teeth_through_skin(plain_actor().deform(instants[i])), 0) << "instant " << i;
    Points pushed = plain_actor().neutral().positions;   // what the measure itself says when a row of teeth is moved out
    const std::vector<Surface> surfaces = plain_actor().neutral().triangle_surfaces();
    std::set<std::uint32_t> crowns;
    for (std::size_t t = 0; t < surfaces.size(); ++t)
        if (surfaces[t] == Surface::teeth) crowns.insert(plain_actor().neutral().triangles[t].begin(), plain_actor().neutral().triangles[t].end());
    for (const std::uint32_t v : crowns) pushed(v, 2) += 8;
    EXPECT_GT(teeth_through_skin(pushed), 20);
}

TEST(HeadMotion, the_mouth_opens_like_a_mouth_and_mouth_close_keeps_it_shut) {
    const Landmarks& marks = plain_actor().landmarks();
    const std::uint32_t lower = vertices_of(marks.lower_lip_line)[marks.lower_lip_line.size() / 2];
    const auto gap = [&](const Instant& instant) {
        const Points p = plain_actor().deform(instant);
        return (p.row(vertices_of(marks.upper_lip_line)[marks.upper_lip_line.size() / 2]) - p.row(lower))
            .norm();
    };
    EXPECT_LT(gap({}), 0.5f);
    EXPECT_GT(gap(with({{"JawOpen", 1.f}})), 22.f);
    EXPECT_LT(gap(with({{"JawOpen", 1.f}})), 45.f);
    EXPECT_LT(gap(with({{"JawOpen", 0.6f}, {"MouthClose", 0.6f}})), 1.5f);
}

TEST(HeadMotion, lids_close_over_the_eye_and_never_cut_it) {
    const Mesh& mesh = plain_actor().neutral();
    const Landmarks& marks = plain_actor().landmarks();
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    std::mt19937 random(5);
    std::vector<Instant> instants = {with({}), with({{"EyeBlinkLeft", 1.f}, {"EyeBlinkRight", 1.f}}),
                                     with({{"EyeWideLeft", 1.f}}),
                                     with({{"EyeLookDownLeft", 1.f}, {"EyeLookDownRight", 1.f}})};
    for (int trial = 0; trial < 15; ++trial) instants.push_back(random_instant(random));
    for (const Instant& instant : instants) {
        const Points points = plain_actor().deform(instant);
        for (int side = 0; side < 2; ++side)
            for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
                if (surfaces[t] != Surface::skin) continue;
                const Triangle& v = mesh.triangles[t];
                const Vec3 a = points.row(v[0]), b = points.row(v[1]), c = points.row(v[2]);
                for (const Vec3& p : {a, Vec3((a + b) / 2), Vec3((a + c) / 2), Vec3((a + b + c) / 3)})
                    ASSERT_GT((p - marks.eye_centre[side]).norm(), marks.eye_radius)
                        << "skin inside the eyeball";
            }
    }
    const Points shut = plain_actor().deform(instants[1]);
    for (int side = 0; side < 2; ++side) {
        const auto upper = vertices_of(marks.upper_lid[side]), lower = vertices_of(marks.lower_lid[side]);
        for (std::size_t i = 0; i < upper.size(); ++i)
            EXPECT_LT((shut.row(upper[i]) - shut.row(lower[i])).norm(), 0.6f);
    }
}

TEST(HeadMotion, one_lid_moves_alone) {
    const Landmarks& marks = plain_actor().landmarks();
    const Points points = plain_actor().deform(with({{"EyeBlinkLeft", 1.f}}));
    for (const std::uint32_t v : vertices_of(marks.upper_lid[0]))
        EXPECT_LT((points.row(v) - plain_actor().neutral().positions.row(v)).norm(), 0.05f);
}

TEST(HeadMotion, eyeballs_turn_by_gaze_or_else_by_weights_about_their_centres) {
    const Mesh& mesh = plain_actor().neutral();
    const Landmarks& marks = plain_actor().landmarks();
    Instant by_gaze;
    by_gaze.gaze.yaw[0] = by_gaze.gaze.yaw[1] = 0.3f;
    const Instant by_weights = with({{"EyeLookOutLeft", 1.f}, {"EyeLookInRight", 1.f}});
    for (const Instant& instant : {by_gaze, by_weights}) {
        const Points points = plain_actor().deform(instant);
        for (int side = 0; side < 2; ++side) {
            const std::uint32_t pupil =
                nearest(mesh.positions, marks.eye_centre[side] + Vec3(0, 0, marks.eye_radius));
            const Vec3 r = points.row(pupil).transpose() - marks.eye_centre[side];
            EXPECT_NEAR(r.norm(), marks.eye_radius, 1e-3);
            EXPECT_GT(r.x(), 2.5f) << "towards the actor's left";
        }
    }
}

TEST(HeadMotion, the_skull_stays_still_whatever_the_face_does) {
    const std::vector<std::uint32_t>& rigid = plain_actor().rigid_vertices();
    EXPECT_GT(rigid.size(), 1500u);
    std::mt19937 random(3);
    for (int trial = 0; trial < 20; ++trial) {
        const Points points = plain_actor().deform(random_instant(random));
        for (const std::uint32_t v : rigid)
            ASSERT_LT((points.row(v) - plain_actor().neutral().positions.row(v)).norm(), 0.02f);
    }
}

TEST(HeadMotion, mirrored_weights_give_the_mirrored_face) {
    const Points& rest = plain_actor().neutral().positions;
    std::map<std::array<int, 3>, std::vector<std::uint32_t>> cells;
    const auto cell = [](const Vec3& p) {
        return std::array<int, 3>{int(std::lround(p.x() * 10)), int(std::lround(p.y() * 10)),
                                  int(std::lround(p.z() * 10))};
    };
    for (std::uint32_t v = 0; v < rest.rows(); ++v) cells[cell(rest.row(v).transpose())].push_back(v);
    std::vector<std::uint32_t> twin(rest.rows(), ~0u);
    int unmatched = 0;
    // Hair is combed to one side.
    const std::vector<Surface> surfaces = plain_actor().neutral().triangle_surfaces();
    std::set<std::uint32_t> hair;
    for (std::size_t t = 0; t < surfaces.size(); ++t)
        if (surfaces[t] == Surface::hair)
            hair.insert(plain_actor().neutral().triangles[t].begin(), plain_actor().neutral().triangles[t].end());
    for (std::uint32_t v = 0; v < rest.rows(); ++v) {
        if (hair.contains(v)) continue;
        const Vec3 p(-rest(v, 0), rest(v, 1), rest(v, 2));
        float best = 1e-3f;
        const auto c = cell(p);
        for (int i = 0; i < 27; ++i) {
            const auto found = cells.find({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
            if (found == cells.end()) continue;
            for (const std::uint32_t u : found->second)
                if (const float d = (rest.row(u).transpose() - p).norm(); d < best) best = d, twin[v] = u;
        }
        if (twin[v] == ~0u) ++unmatched, ADD_FAILURE() << "no mirror image of " << rest.row(v);
    }
    EXPECT_EQ(unmatched, 0);
    const Points left = plain_actor().deform(
        with({{"MouthSmileLeft", 0.7f}, {"EyeBlinkLeft", 0.5f}, {"BrowDownLeft", 1.f}, {"JawLeft", 0.5f}}));
    const Points right = plain_actor().deform(with(
        {{"MouthSmileRight", 0.7f}, {"EyeBlinkRight", 0.5f}, {"BrowDownRight", 1.f}, {"JawRight", 0.5f}}));
    for (std::uint32_t v = 0; v < rest.rows(); ++v) {
        if (twin[v] == ~0u) continue;
        ASSERT_LT((Vec3(-left(v, 0), left(v, 1), left(v, 2)) - right.row(twin[v]).transpose()).norm(), 0.02f)
            << rest.row(v);
    }
}

TEST(HeadMotion, the_same_seed_gives_the_same_head_and_another_seed_another) {
    const auto one = make_procedural_actor(5), again = make_procedural_actor(5),
               other = make_procedural_actor(6);
    const Instant smile = with({{"MouthSmileLeft", 1.f}, {"JawOpen", 0.4f}});
    EXPECT_EQ(one->deform(smile), again->deform(smile));
    ASSERT_EQ(one->neutral().triangles, other->neutral().triangles);
    EXPECT_EQ(one->neutral().texcoord_triangles, other->neutral().texcoord_triangles);
    EXPECT_GT((one->neutral().positions - other->neutral().positions).rowwise().norm().maxCoeff(), 1.f);
    EXPECT_EQ(plain_actor().neutral().triangles, other->neutral().triangles);
}

}  // namespace
}  // namespace mien::samples
