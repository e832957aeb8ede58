#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "encoder/blend_coefficients.hpp"
#include "encoder/slits.hpp"
#include "core/surface_distance.hpp"
#include "samples/markers.hpp"
#include "samples/procedural_actor.hpp"
#include "speech.hpp"

namespace mien::encoder {
namespace {

/// One actor with 182 markers and the blend coefficients that follow.
struct Face {
    std::unique_ptr<samples::Actor> actor = samples::make_procedural_actor(1);
    const Mesh& mesh = actor->neutral();
    std::vector<Site> sites = samples::place_markers(*actor, 182);
    SurfaceDistance skin{mesh, 1u << int(Surface::skin)};
    std::vector<Slit> slits = find_slits(mesh, skin);
    model::BlendBase base = *blend_coefficients(mesh, sites, actor->rigid_vertices());

    const Slit& mouth() const { return *std::find_if(slits.begin(), slits.end(), [](const Slit& s) { return s.mouth; }); }
    Vec3 position(std::uint32_t v) const { return mesh.positions.row(v).transpose(); }

    /// Offsets of all vertices from those of the markers.
    Points blend(const Points& markers) const {
        Points offsets = Points::Zero(mesh.vertex_count(), 3);
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            for (std::uint32_t i = base.row_start[v]; i < base.row_start[v + 1]; ++i)
                offsets.row(v) += base.terms[i].weight * markers.row(base.terms[i].marker);
        return offsets;
    }
    Points markers_of(const Points& offsets) const {
        Points markers(Eigen::Index(sites.size()), 3);
        for (std::size_t m = 0; m < sites.size(); ++m) markers.row(Eigen::Index(m)) = sites[m].position(offsets).transpose();
        return markers;
    }
};

const Face& face() {
    static const Face one;
    return one;
}

std::vector<Surface> surfaces(const Mesh& mesh) {
    std::vector<Surface> of_vertex(mesh.vertex_count(), Surface::other);
    const auto of_triangle = mesh.triangle_surfaces();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const std::uint32_t v : mesh.triangles[t]) of_vertex[v] = of_triangle[t];
    return of_vertex;
}

TEST(Slits, AreTheTwoEyesAndTheMouthWhereTheActorHasThem) {
    const auto& marks = face().actor->landmarks();
    ASSERT_EQ(face().slits.size(), 3u);
    EXPECT_EQ(std::count_if(face().slits.begin(), face().slits.end(), [](const Slit& s) { return s.mouth; }), 1);
    const Slit& mouth = face().mouth();
    EXPECT_NEAR(mouth.line.front().x(), marks.upper_lip_line.front().x(), 6);
    EXPECT_NEAR(mouth.line.back().x(), marks.upper_lip_line.back().x(), 6);
    for (const Vec3& p : mouth.line) {
        float nearest = 1e9f;
        for (const Vec3& q : marks.upper_lip_line) nearest = std::min(nearest, std::hypot(p.x() - q.x(), p.y() - q.y()));
        EXPECT_LT(nearest, 5) << p.transpose();
    }
    for (std::size_t i = 1; i < mouth.line.size(); ++i) EXPECT_GT(mouth.line[i].x(), mouth.line[i - 1].x());
    const auto side_at = [&](const Vec3& p) {
        Eigen::Index v = 0;
        (face().mesh.positions.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff(&v);
        return mouth.sides[std::size_t(v)];
    };
    const auto &upper = marks.upper_lip_outline, &lower = marks.lower_lip_outline;
    EXPECT_EQ(side_at(upper[upper.size() / 2]), Side::above);
    EXPECT_EQ(side_at(lower[lower.size() / 2]), Side::below);
    EXPECT_EQ(side_at(marks.ear[0]), Side::beside);
}

TEST(Blend, SharesArePositiveAndNeverAddUpToMoreThanAll) {
    const model::BlendBase& base = face().base;
    ASSERT_EQ(base.row_start.size(), face().mesh.vertex_count() + 1u);
    for (std::uint32_t v = 0; v < face().mesh.vertex_count(); ++v) {
        double sum = 0;
        for (std::uint32_t i = base.row_start[v]; i < base.row_start[v + 1]; ++i) {
            EXPECT_GT(base.terms[i].weight, 0);
            EXPECT_LT(base.terms[i].marker, 182u);
            EXPECT_TRUE(i == base.row_start[v] || base.terms[i].marker > base.terms[i - 1].marker) << "ascending";
            sum += base.terms[i].weight;
        }
        EXPECT_LE(sum, 1.0001) << v;
    }
}

TEST(Blend, MarkersThatMoveAsOneCarryTheMiddleOfTheFaceAndLeaveTheSkullAndTheNeck) {
    const Vec3 by(3, -2, 5);
    Points markers(182, 3);
    markers.rowwise() = by.transpose();
    const Points offsets = face().blend(markers);
    const auto& marks = face().actor->landmarks();
    const auto surface = surfaces(face().mesh);
    int middle = 0;
    for (std::uint32_t v = 0; v < face().mesh.vertex_count(); ++v) {
        const Vec3 p = face().position(v);
        EXPECT_TRUE(surface[v] != Surface::eye || offsets.row(v).norm() == 0) << "gaze turns eyes";
        // Every skin that sits between the brows, the cheeks and the chin is far from the still ring.
        const bool in_middle = surface[v] == Surface::skin && face().skin.carries(v) && p.z() > marks.cheek[0].z() && p.y() < marks.glabella.y() &&
                               p.y() > marks.chin.y() + 5 && std::abs(p.x()) < std::abs(marks.cheek[0].x());
        if (!in_middle) continue;
        ++middle;
        EXPECT_LT((offsets.row(v).transpose() - by).norm(), 0.02f * by.norm()) << p.transpose();
    }
    EXPECT_GT(middle, 1000);
    for (const std::uint32_t v : face().actor->rigid_vertices()) EXPECT_EQ(offsets.row(v).norm(), 0);
    Eigen::Index lowest = 0;
    face().mesh.positions.col(1).minCoeff(&lowest);
    EXPECT_LT(offsets.row(lowest).norm(), 0.02f * by.norm()) << "the foot of the neck";
}

TEST(Blend, SkinAboveASlitSharesNoMarkerWithSkinBelowIt) {
    for (const Slit& slit : face().slits)
        for (std::uint32_t v = 0; v < face().mesh.vertex_count(); ++v) {
            if (!face().skin.carries(v) || slit.sides[v] == Side::beside) continue;
            for (std::uint32_t i = face().base.row_start[v]; i < face().base.row_start[v + 1]; ++i) {
                const Side marker = slit.sides[face().sites[face().base.terms[i].marker].vertices[0]];
                EXPECT_GE(int(marker) * int(slit.sides[v]), 0) << "vertex " << v << " at " << face().position(v).transpose();
            }
        }
}

TEST(Blend, UpperTeethStayWithTheSkullAndLowerOnesFollowTheChin) {
    samples::Instant open;
    open.weights[std::size_t(samples::arkit_index("JawOpen"))] = 0.6f;
    const Points truth = face().actor->deform(open) - face().mesh.positions;
    const Points blended = face().blend(face().markers_of(truth));
    const auto surface = surfaces(face().mesh);
    int upper = 0, lower = 0;
    for (std::uint32_t v = 0; v < face().mesh.vertex_count(); ++v) {
        if (surface[v] != Surface::teeth) continue;
        const bool still = truth.row(v).norm() < 0.1f;
        ++(still ? upper : lower);
        EXPECT_LE((blended.row(v) - truth.row(v)).norm(), still ? 0.1f : 0.35f * truth.row(v).norm()) << face().position(v).transpose();
    }
    EXPECT_GT(upper, 100);
    EXPECT_GT(lower, 100);
}

TEST(Blend, MarkersStandInForAllVerticesOfSpeechWithinAMillimetre) {
    const auto surface = surfaces(face().mesh);
    const samples::Performance performance = samples::some_speech();
    double error = 0, moved = 0, count = 0;
    for (std::int64_t f = 0; f < performance.frames(); f += 5) {
        const Points truth = face().actor->deform(performance.instants[std::size_t(f)]) - face().mesh.positions;
        const Points blended = face().blend(face().markers_of(truth));
        for (std::uint32_t v = 0; v < face().mesh.vertex_count(); ++v) {
            if (surface[v] == Surface::eye) continue;  // gaze turns them
            error += (blended.row(v) - truth.row(v)).norm();
            moved += truth.row(v).norm();
            ++count;
        }
    }
    EXPECT_GT(moved / count, 0.4) << "mm: somebody speaks";
    EXPECT_LT(error / count, 0.35) << "mm";
}

}  // namespace
}  // namespace mien::encoder
