#include <gtest/gtest.h>

#include <algorithm>

#include "encoder/blend_coefficients.hpp"
#include "encoder/contacts.hpp"
#include "encoder/slits.hpp"
#include "core/surface_distance.hpp"
#include "samples/ict_actor.hpp"
#include "samples/live_take.hpp"
#include "samples/markers.hpp"
#include "samples/procedural_actor.hpp"
#include "speech.hpp"
#include "tests/recordings.hpp"

namespace mien::encoder {
namespace {

struct Nearest {
    Vec3 point = Vec3::Zero();
    Vec3 share = Vec3::Zero();  // barycentric
};

/// The point of triangle a b c that is nearest to p (Ericson, Real-Time Collision Detection, section 5.1.5).
Nearest nearest_on(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto at = [&](float u, float v, float w) { return Nearest{u * a + v * b + w * c, Vec3(u, v, w)}; };
    const Vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const float d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d1 <= 0 && d2 <= 0) return at(1, 0, 0);
    if (d3 >= 0 && d4 <= d3) return at(0, 1, 0);
    if (d6 >= 0 && d5 <= d6) return at(0, 0, 1);
    const float va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(1 - d1 / (d1 - d3), d1 / (d1 - d3), 0);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(1 - d2 / (d2 - d6), 0, d2 / (d2 - d6));
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return at(0, 1 - w, w);
    }
    const float sum = va + vb + vc;
    return at(va / sum, vb / sum, vc / sum);
}

/// How deep one lip is inside the other, measured on the surfaces themselves and not by what holds them apart: the greatest
/// distance of a vertex of either lip behind the skin of the other.
class Overlap {
public:
    Overlap(const Mesh& mesh) : mesh_(mesh) {
        const SurfaceDistance skin(mesh, 1u << int(Surface::skin));
        const auto slits = find_slits(mesh, skin);
        const Slit& mouth = *std::find_if(slits.begin(), slits.end(), [](const Slit& s) { return s.mouth; });
        const auto surface = mesh.triangle_surfaces();
        const auto near = [&](std::uint32_t v) {
            return std::any_of(mouth.line.begin(), mouth.line.end(), [&](const Vec3& p) { return (p - mesh.positions.row(v).transpose()).norm() < 8; });
        };
        std::vector<char> seen[2] = {std::vector<char>(mesh.vertex_count()), std::vector<char>(mesh.vertex_count())};
        std::vector<int> other(mesh.vertex_count());  // triangles that lead away from the lip
        for (std::size_t t = 0; t < surface.size(); ++t) {
            const Triangle& triangle = mesh.triangles[t];
            const Side side = mouth.sides[triangle[0]];
            const bool lip = surface[t] == Surface::skin && side != Side::beside &&
                             std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return mouth.sides[v] == side && near(v); });
            if (!lip) {
                for (const std::uint32_t v : triangle) ++other[v];
                continue;
            }
            triangles_[side == Side::above].push_back(triangle);
            for (const std::uint32_t v : triangle) seen[side == Side::above][v] = 1;
        }
        // In the corners both lips are one skin, which folds and cannot cross.
        for (const Side side : {Side::below, Side::above}) {
            std::vector<std::pair<std::uint32_t, float>> other_lip;
            for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
                if (skin.carries(v) && int(mouth.sides[v]) == -int(side)) other_lip.emplace_back(v, 0.0f);
            std::vector<char> corner(mesh.vertex_count());
            for (const auto& r : skin.from(other_lip, kCorner)) corner[r.vertex] = 1;
            for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
                if (seen[side == Side::above][v] && !corner[v]) vertices_[side == Side::above].push_back(v);
        }
        border_.resize(mesh.vertex_count());
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) border_[v] = other[v] > 0;
        // What the skin's folds put behind the other lip at rest, when nothing presses, is no overlap.
        const Points normals = vertex_normals(mesh.positions, mesh.triangles);
        for (int side = 0; side < 2; ++side)
            folded_ += std::erase_if(vertices_[side], [&](std::uint32_t v) { return depth(v, triangles_[1 - side], mesh.positions, normals) > 0.05f; });
    }

    std::size_t folded() const { return folded_; }
    std::size_t vertices() const { return vertices_[0].size() + vertices_[1].size(); }
    std::size_t size() const { return std::min(triangles_[0].size(), triangles_[1].size()); }

    float deepest(const Points& points) const {
        const Points normals = vertex_normals(points, mesh_.triangles);
        float deepest = 0;
        for (int side = 0; side < 2; ++side)
            for (const std::uint32_t v : vertices_[side]) deepest = std::max(deepest, depth(v, triangles_[1 - side], points, normals));
        return deepest;
    }

private:
    static constexpr float kCorner = 1.5f;  // mm along the skin to the other lip
    static constexpr float kDeep = 3;  // mm; what is farther behind a lip is inside the mouth

    float depth(std::uint32_t v, const std::vector<Triangle>& lip, const Points& points, const Points& normals) const {
        const Vec3 p = points.row(v).transpose();
        float best = kDeep * kDeep;
        const Triangle* where = nullptr;
        Nearest nearest;
        for (const Triangle& t : lip) {
            const Nearest n = nearest_on(p, points.row(t[0]).transpose(), points.row(t[1]).transpose(), points.row(t[2]).transpose());
            if ((n.point - p).squaredNorm() < best) best = (n.point - p).squaredNorm(), nearest = n, where = &t;
        }
        if (!where) return 0;
        Vec3 normal = Vec3::Zero();
        for (int i = 0; i < 3; ++i) {
            normal += nearest.share[i] * normals.row((*where)[std::size_t(i)]).transpose();
            if (nearest.share[i] > 0.999f && border_[(*where)[std::size_t(i)]]) return 0;  // beyond the edge of the lip
            if (nearest.share[i] < 0.001f && border_[(*where)[std::size_t((i + 1) % 3)]] && border_[(*where)[std::size_t((i + 2) % 3)]]) return 0;
        }
        return (p - nearest.point).dot(normal) < 0 ? std::sqrt(best) : 0;
    }

    const Mesh& mesh_;
    std::vector<Triangle> triangles_[2];        // lower, upper
    std::vector<std::uint32_t> vertices_[2];
    std::vector<char> border_;
    std::size_t folded_ = 0;
};

struct Figures {
    float truth = 0, linear = 0, held = 0;        // mm, deepest of all frames
    float widest = 0;                             // mm between facing lips, of the truth
    std::size_t pairs = 0;
    double linear_error = 0, held_error = 0;      // mm, mean of all vertices and frames
    float furthest = 0;                           // mm that anything was pushed
};

Figures measure(const samples::Actor& actor, const samples::Performance& performance, std::int64_t every) {
    const Mesh& mesh = actor.neutral();
    const auto sites = samples::place_markers(actor, 182);
    model::FaceModel face;
    face.neutral = mesh;
    face.base = *blend_coefficients(mesh, sites, actor.rigid_vertices());
    const auto contacts = find_contacts(mesh);
    const auto contact = contacts.begin();  // of the mouth
    EXPECT_EQ(contacts.size(), 3u);
    if (contacts.empty()) return {};
    const Overlap overlap(mesh);
    EXPECT_GT(overlap.size(), 150u);
    EXPECT_LT(overlap.folded(), overlap.vertices() / 50) << "of " << overlap.vertices() << "; the ICT rig at rest overlaps in eight places near the corners";
    Figures figures;
    figures.pairs = contact->pairs.size();
    double count = 0;
    for (std::int64_t f = 0; f < performance.frames(); f += every) {
        samples::Instant instant = performance.instants[std::size_t(f)];
        instant.head = {};
        instant.gaze = {};
        const Points truth = actor.deform(instant);
        model::LinearMotion markers{Eigen::VectorXf::Zero(3 * Eigen::Index(sites.size())), Eigen::MatrixXf(3 * Eigen::Index(sites.size()), 1)};
        for (std::size_t m = 0; m < sites.size(); ++m)
            markers.components.col(0).segment<3>(3 * Eigen::Index(m)) = sites[m].position(truth) - sites[m].position(mesh.positions);
        model::Motion motion;
        motion.coefficients = Eigen::VectorXf::Ones(1);
        const auto composed = model::compose(face, markers);
        face.contacts.clear();
        const Points linear = model::evaluate(face, composed, motion);
        face.contacts = {*contact};
        const Points held = model::evaluate(face, composed, motion);
        for (const auto& [upper, lower] : contact->pairs) figures.widest = std::max(figures.widest, truth(upper, 1) - truth(lower, 1));
        figures.truth = std::max(figures.truth, overlap.deepest(truth));
        figures.linear = std::max(figures.linear, overlap.deepest(linear));
        figures.held = std::max(figures.held, overlap.deepest(held));
        figures.linear_error += (linear - truth).rowwise().norm().mean();
        figures.held_error += (held - truth).rowwise().norm().mean();
        figures.furthest = std::max(figures.furthest, (held - linear).rowwise().norm().maxCoeff());
        ++count;
    }
    figures.linear_error /= count, figures.held_error /= count;
    std::printf("lips overlap by at most %.3f mm (truth), %.3f (linear), %.3f (held apart); mean error %.4f -> %.4f mm; pushed by at most %.2f mm, %zu pairs, %zu members\n",
                double(figures.truth), double(figures.linear), double(figures.held), figures.linear_error, figures.held_error,
                double(figures.furthest), contact->pairs.size(), contact->members.size());
    return figures;
}

void expect_lips_apart(const Figures& figures) {
    EXPECT_GT(figures.pairs, 30u);
    EXPECT_GT(figures.widest, 5) << "mm between the lips";
    EXPECT_GT(figures.linear, 0.3f) << "mm: the weights alone let them pass, or this shows nothing";
    EXPECT_LT(figures.held, 0.1f) << "mm";
    EXPECT_LT(figures.held_error, figures.linear_error * 1.01);
}

TEST(Lips, NeverCrossWhenMarkersMoveTheProceduralHeadThroughSpeech) {
    expect_lips_apart(measure(*samples::make_procedural_actor(1), samples::some_speech(), 3));
}

TEST(Lips, NeverCrossWhenMarkersMoveTheIctHeadThroughARealTake) {
    const auto data = tests::recordings();
    if (data.empty()) GTEST_SKIP() << "skipped: no recordings";
    const auto actor = samples::make_ict_actor(data / "ict_facekit");
    const auto take = samples::perform_take(data / "livelinkface/neurosync_testset.csv");
    ASSERT_TRUE(actor.ok() && take.ok());
    expect_lips_apart(measure(**actor, *take, 17));
}

}  // namespace
}  // namespace mien::encoder
