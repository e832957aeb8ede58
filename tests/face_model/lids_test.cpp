#include <gtest/gtest.h>

#include <algorithm>

#include "core/surface_distance.hpp"
#include "encoder/blend_coefficients.hpp"
#include "encoder/contacts.hpp"
#include "encoder/lid_margins.hpp"
#include "encoder/lids.hpp"
#include "samples/ict_actor.hpp"
#include "samples/live_take.hpp"
#include "samples/markers.hpp"
#include "samples/procedural_actor.hpp"
#include "speech.hpp"
#include "tests/recordings.hpp"

namespace mien::encoder {
namespace {

/// Gaps between the lids where they are open, mm.
struct Gaps {
    float neutral = 0, truth = 0, plain = 0, lids = 0;   // the widest of an eye: at neutral, and when the lids are shut
    double plain_error = 0, lids_error = 0;  // mm, mean of the vertices of the lids at that moment
};

Points drawn(const model::FaceModel& face, const std::vector<Site>& sites, const Points& truth) {
    model::LinearMotion markers{Eigen::VectorXf::Zero(3 * Eigen::Index(sites.size())), Eigen::MatrixXf(3 * Eigen::Index(sites.size()), 1)};
    for (std::size_t m = 0; m < sites.size(); ++m)
        markers.components.col(0).segment<3>(3 * Eigen::Index(m)) = sites[m].position(truth) - sites[m].position(face.neutral.positions);
    model::Motion motion;
    motion.coefficients = Eigen::VectorXf::Ones(1);
    return model::evaluate(face, model::compose(face, markers), motion);
}

Gaps measure(const samples::Actor& actor, const samples::Performance& performance) {
    const Mesh& mesh = actor.neutral();
    const SurfaceDistance skin(mesh, 1u << int(Surface::skin));
    const auto sites = samples::place_markers(actor, 182);
    model::FaceModel plain;
    plain.neutral = mesh;
    plain.base = *blend_coefficients(mesh, sites, actor.rigid_vertices());
    model::FaceModel face = plain;
    for (model::Lid& lid : find_lids(mesh, sites)) model::add_lid(face, std::move(lid));
    face.contacts = find_contacts(mesh);
    EXPECT_EQ(face.lids.size(), 2u);
    std::vector<std::array<std::uint32_t, 2>> margins;
    for (const Slit& slit : find_slits(mesh, skin))
        if (!slit.mouth)
            for (const auto& pair : lid_margins(mesh, skin, slit)) margins.push_back(pair);
    const auto widest = [&](const Points& points) {
        float gap = 0;
        for (const auto& [upper, lower] : margins) gap = std::max(gap, points(upper, 1) - points(lower, 1));
        return gap;
    };
    Gaps gaps;
    gaps.neutral = widest(mesh.positions);
    const auto blink = [](const samples::Instant& instant) {
        static const auto right = std::size_t(samples::arkit_index("EyeBlinkRight")), left = std::size_t(samples::arkit_index("EyeBlinkLeft"));
        return std::min(instant.weights[right], instant.weights[left]);
    };
    samples::Instant instant = *std::max_element(performance.instants.begin(), performance.instants.end(), [&](const auto& a, const auto& b) { return blink(a) < blink(b); });
    instant.head = {};
    instant.gaze = {};
    const Points shut = actor.deform(instant);
    gaps.truth = widest(shut);
    const Points without = drawn(plain, sites, shut), with = drawn(face, sites, shut);
    gaps.plain = widest(without);
    gaps.lids = widest(with);
    std::size_t members = 0;
    for (const model::Lid& lid : face.lids)
        for (const auto& member : lid.members) {
            gaps.plain_error += (without.row(member.vertex) - shut.row(member.vertex)).norm();
            gaps.lids_error += (with.row(member.vertex) - shut.row(member.vertex)).norm();
            ++members;
        }
    gaps.plain_error /= double(members), gaps.lids_error /= double(members);
    std::printf("lids are open by %.2f mm at rest; shut %.2f (truth), %.2f (blended), %.2f (as lids); mean error of %zu vertices %.2f -> %.2f mm\n",
                double(gaps.neutral), double(gaps.truth), double(gaps.plain), double(gaps.lids), members, gaps.plain_error, gaps.lids_error);
    return gaps;
}

void expect_shut(const Gaps& gaps) {
    EXPECT_GT(gaps.neutral, 9) << "mm";
    EXPECT_GT(gaps.plain, 4) << "mm: the weights alone leave them ajar, or this shows nothing";
    EXPECT_LT(gaps.lids, gaps.truth + 1) << "mm";
    EXPECT_LT(gaps.lids_error, 0.85 * gaps.plain_error) << "mm";
}

TEST(Lids, CloseWhenMarkersMoveTheProceduralHead) {
    expect_shut(measure(*samples::make_procedural_actor(1), samples::some_speech()));
}

TEST(Lids, RestWhereMarkersRestAndAreNoneWithoutMarkersOnThem) {
    const auto actor = samples::make_procedural_actor(1);
    const Mesh& mesh = actor->neutral();
    auto sites = samples::place_markers(*actor, 182);
    model::FaceModel face;
    face.neutral = mesh;
    face.base = *blend_coefficients(mesh, sites, actor->rigid_vertices());
    for (model::Lid& lid : find_lids(mesh, sites)) model::add_lid(face, std::move(lid));
    EXPECT_LT((drawn(face, sites, mesh.positions) - mesh.positions).rowwise().norm().maxCoeff(), 1e-4f);
    const auto contacts = find_contacts(mesh);
    ASSERT_EQ(contacts.size(), 3u);
    face.contacts = {contacts[1], contacts[2]};  // lips touch at rest
    EXPECT_LT((drawn(face, sites, mesh.positions) - mesh.positions).rowwise().norm().maxCoeff(), 0.011f) << "open lids stay where they are";
    const auto& lids = face.lids;
    ASSERT_EQ(lids.size(), 2u);
    std::erase_if(sites, [&](const Site& site) {
        return std::any_of(lids.begin(), lids.end(), [&](const model::Lid& lid) {
            return std::any_of(lid.members.begin(), lid.members.end(), [&](const auto& member) {
                return member.share > 0 && std::find(std::begin(site.vertices), std::end(site.vertices), member.vertex) != std::end(site.vertices);
            });
        });
    });
    EXPECT_LT(sites.size(), 182u);
    EXPECT_TRUE(find_lids(mesh, sites).empty());
}

TEST(Lids, CloseWhenMarkersMoveTheIctHead) {
    const auto data = tests::recordings();
    if (data.empty()) GTEST_SKIP() << "skipped: no recordings";
    const auto actor = samples::make_ict_actor(data / "ict_facekit");
    const auto take = samples::perform_take(data / "livelinkface/neurosync_testset.csv");
    ASSERT_TRUE(actor.ok() && take.ok());
    expect_shut(measure(**actor, *take));
}

}  // namespace
}  // namespace mien::encoder
