#include <gtest/gtest.h>

#include <map>

#include "analysis/marker_placement.hpp"
#include "coding/detail_code.hpp"
#include "decoder/model_decoder.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/model_remap.hpp"
#include "samples/markers.hpp"
#include "samples/procedural_actor.hpp"
#include "tests/detail/small_model.hpp"

namespace mien {
namespace {

/// The small model as mien train stores it, and as a decoder has it.
encoder::EncodedModel stored_model() {
    const SmallModel small;
    auto coded = encoder::encode_detail(small.model, small.moments, "sheet");
    encoder::EncodedModel model{coded->manifest, coded->blobs, {}};
    return model;
}

Result<model::FaceModel> decode(const encoder::EncodedModel& model) {
    std::map<Hash, Bytes> blobs;
    for (const auto& blob : model.blobs) blobs[blob.hash] = blob.bytes;
    return decoder::decode_model(model.manifest, [&](const Hash& hash) -> const Bytes* {
        const auto found = blobs.find(hash);
        return found == blobs.end() ? nullptr : &found->second;
    });
}

struct Remap : testing::Test {
    encoder::EncodedModel model = stored_model();
    SmallModel small;
    Remap() { model.model = std::move(*decode(model)); }

    const model::ShellBase& shell(const model::FaceModel& face) const { return std::get<model::ShellBase>(face.base); }
    Points at_rest(const std::vector<Site>& sites) const {
        Points rest(Eigen::Index(sites.size()), 3);
        for (std::size_t m = 0; m < sites.size(); ++m) rest.row(Eigen::Index(m)) = sites[m].position(model.model.neutral.positions).transpose();
        return rest;
    }
    /// Base shape with medium detail when the markers are at `markers`.
    static Points formed(const model::FaceModel& face, const Points& markers) {
        const auto& base = std::get<model::ShellBase>(face.base);
        Points points = face.neutral.positions;
        points += base.response * (markers - base.markers);
        face.detail->add_medium(face.detail->parameters(points), points);
        return points;
    }
};

TEST_F(Remap, TheSameMarkersGiveTheSameFaceAndAlmostNothingToFetch) {
    const auto& own = shell(model.model);
    const auto same = encoder::remap_markers(model, own.sites, own.markers);
    ASSERT_TRUE(same.ok()) << same.error().message;
    const auto face = decode(*same);
    ASSERT_TRUE(face.ok()) << face.error().message;
    EXPECT_EQ(shell(*face).response, shell(same->model).response);
    EXPECT_EQ(shell(*face).markers, shell(same->model).markers);
    const Points moved = small.clip.markers->frame(7);
    EXPECT_LT((formed(*face, moved) - formed(model.model, moved)).rowwise().norm().maxCoeff(), 0.02);
    std::size_t fresh = 0;
    for (const auto& blob : same->blobs)
        if (blob.hash != same->manifest && std::none_of(model.blobs.begin(), model.blobs.end(), [&](const auto& old) { return old.hash == blob.hash; })) fresh += blob.bytes.size();
    EXPECT_LT(fresh, 300u) << "where the markers are";
    EXPECT_LT(same->blobs.front().bytes.size(), model.blobs.front().bytes.size() + 64) << "the manifest: it names one blob more";
    EXPECT_LE(same->blobs.size(), model.blobs.size() + 1);
}

TEST_F(Remap, MarkersBetweenTheTrainedOnesDriveTheSameDetail) {
    // A marker in the middle of every other marker triangle: another layout, half as dense.
    std::vector<Site> sites;
    const auto& triangles = small.model.marker_triangles;
    const Points trained = at_rest(model.model.detail->model().sites);
    Points middles(Eigen::Index(triangles.size() / 2), 3);
    for (Eigen::Index i = 0; i < middles.rows(); ++i) {
        const Triangle& t = triangles[std::size_t(2 * i)];
        middles.row(i) = (trained.row(t[0]) + trained.row(t[1]) + trained.row(t[2])) / 3;
    }
    const auto placed = analysis::place_markers(model.model.neutral, middles, Points());
    const auto remapped = encoder::remap_markers(model, placed.sites, placed.rest);
    ASSERT_TRUE(remapped.ok()) << remapped.error().message;
    const auto face = decode(*remapped);
    ASSERT_TRUE(face.ok()) << face.error().message;
    // What the trained markers make of a frame is what the new ones see.
    const Points frame = small.clip.markers->frame(9);
    const auto& own = shell(model.model);
    Points base = model.model.neutral.positions;
    base += own.response * (frame - own.markers);
    Points seen = placed.rest;
    for (std::size_t m = 0; m < placed.sites.size(); ++m)
        seen.row(Eigen::Index(m)) += (placed.sites[m].position(base) - placed.sites[m].position(model.model.neutral.positions)).transpose();
    const Points truth = formed(model.model, frame), got = formed(*face, seen);
    const double moved = double((truth - model.model.neutral.positions).rowwise().norm().mean());
    EXPECT_GT(moved, 0.3);
    EXPECT_LT(double((truth - got).rowwise().norm().mean()), 0.25 * moved);
    // Offsets that the new markers do not have move nothing but detail at rest.
    EXPECT_LT((formed(*face, shell(*face).markers) - formed(model.model, own.markers)).rowwise().norm().maxCoeff(), 0.02);
}

TEST_F(Remap, RefusesWhatCannotDriveIt) {
    const auto& own = shell(model.model);
    const std::vector<Site> three(own.sites.begin(), own.sites.begin() + 3);
    EXPECT_FALSE(encoder::remap_markers(model, three, own.markers.topRows(3)).ok());
    Points far = own.markers;
    far(0, 2) += 200;
    EXPECT_FALSE(encoder::remap_markers(model, own.sites, far).ok());
    far(0, 2) = std::nanf("");
    EXPECT_FALSE(encoder::remap_markers(model, own.sites, far).ok());
    encoder::EncodedModel plain = model;
    plain.model.base = model::VertexBase{};
    EXPECT_FALSE(encoder::remap_markers(plain, own.sites, own.markers).ok());
}

TEST_F(Remap, DamagedDrivingMarkersAreRefused) {
    const auto& own = shell(model.model);
    const auto remapped = encoder::remap_markers(model, own.sites, own.markers);
    ASSERT_TRUE(remapped.ok());
    const auto blob = std::find_if(remapped->blobs.begin(), remapped->blobs.end(), [](const auto& b) { return b.kind == protocol::BlobKind::driving_markers; });
    ASSERT_NE(blob, remapped->blobs.end());
    for (std::size_t n = 0; n < blob->bytes.size(); ++n)
        EXPECT_FALSE(coding::decode_driving_markers(ByteView(blob->bytes).first(n), model.model.neutral.vertex_count()).ok()) << n;
    EXPECT_FALSE(coding::decode_driving_markers(blob->bytes, 3).ok()) << "sites beyond the mesh";
    encoder::EncodedModel lost = *remapped;
    std::erase_if(lost.blobs, [](const auto& b) { return b.kind == protocol::BlobKind::driving_markers; });
    EXPECT_FALSE(decode(lost).ok());
}

TEST(DrivingMarkers, AreWrittenByteByByte) {
    coding::DrivingMarkers markers;
    markers.sites = {Site::at_vertex(1), Site::at_vertex(5), Site{{7, 8, 9}, {0.25f, 0.5f, 0.25f}}};
    markers.rest_offsets.setZero(3, 3);
    markers.rest_offsets(1, 2) = -1.0f;
    markers.rest_offsets(2, 0) = 1.0f / 64;
    const std::vector<int> literal{3, 1, 0, 0, 5, 0, 0, 7, 2, 4, 0x80, 0x20, 0x80, 0x10, 0, 0, 0, 0, 0, 0x7f, 2, 0, 0};
    const Bytes bytes = coding::encode_driving_markers(markers);
    ASSERT_EQ(bytes.size(), literal.size());
    for (std::size_t i = 0; i < literal.size(); ++i) EXPECT_EQ(std::to_integer<int>(bytes[i]), literal[i]) << i;
    const auto back = coding::decode_driving_markers(bytes, 10);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->rest_offsets, markers.rest_offsets);
}

TEST(MarkerPlacement, FindsARigidMotionAndKeepsMarkersOnTheSkin) {
    const auto actor = samples::make_procedural_actor(1);
    const Mesh& mesh = actor->neutral();
    const std::vector<Site> sites = samples::place_markers(*actor, 60);
    Points rest(Eigen::Index(sites.size()), 3);
    for (std::size_t m = 0; m < sites.size(); ++m) rest.row(Eigen::Index(m)) = sites[m].position(mesh.positions).transpose();
    RigidPose pose;
    pose.rotation = Eigen::AngleAxisf(0.2f, Vec3(1, 2, 0.5f).normalized());
    pose.translation = Vec3(4, -30, 60);
    Points elsewhere = rest, surface = mesh.positions;   // eyes, teeth and all: what is no skin must not pull
    apply_pose(pose, elsewhere);
    apply_pose(pose, surface);
    for (const Points& held : {surface, Points()}) {
        const auto placed = analysis::place_markers(mesh, elsewhere, held);
        EXPECT_LT(placed.largest, 0.1);
        EXPECT_LT((placed.rest - rest).rowwise().norm().maxCoeff(), 0.3);
        auto wrong = placed;
        analysis::misplace(wrong, mesh, 2, 1);
        EXPECT_EQ(wrong.rest, placed.rest);
        for (std::size_t m = 0; m < wrong.sites.size(); ++m) {
            const float by = (wrong.sites[m].position(mesh.positions) - placed.sites[m].position(mesh.positions)).norm();
            EXPECT_LT(by, 2.3f);
            EXPECT_GT(by, 0.5f);
        }
    }
}

}  // namespace
}  // namespace mien
