#include <gtest/gtest.h>

#include <map>

#include "coding/layer_code.hpp"
#include "decoder/model_decoder.hpp"
#include "encoder/model_encoder.hpp"
#include "meshes.hpp"
#include "protocol/messages.hpp"

namespace mien {
namespace {

using protocol::LayerKind;
using protocol::MotionKind;

/// A bent sheet for skin, two small balls for eyes.
Mesh small_head() {
    Mesh mesh = sheet(15);
    const auto skin = std::uint32_t(mesh.triangles.size());
    for (const float x : {7.0f, 21.0f}) {
        const std::uint32_t first = mesh.vertex_count();
        mesh.positions.conservativeResize(first + 6, 3);
        mesh.positions.bottomRows(6) << x - 3, 20, -4, x + 3, 20, -4, x, 17, -4, x, 23, -4, x, 20, -7, x, 20, -1;
        for (const std::uint32_t pole : {4u, 5u}) {
            const std::uint32_t ring[] = {0, 3, 1, 2};
            for (std::uint32_t i = 0; i < 4; ++i) mesh.triangles.push_back({first + pole, first + ring[i], first + ring[(i + 1) % 4]});
        }
    }
    mesh.texcoord_triangles.resize(mesh.triangles.size(), {0, 1, 2});
    mesh.parts = {{"skin", Surface::skin, 0, skin}, {"eyes", Surface::eye, skin, std::uint32_t(mesh.triangles.size()) - skin}};
    return mesh;
}

/// A clip of the same actor; `take` changes what is performed, not who performs.
Clip small_clip(unsigned take = 0) {
    Clip clip;
    clip.neutral = small_head();
    const auto V = clip.neutral->vertex_count();
    std::srand(take + 1);
    clip.vertices = PointSequence(3, V);
    clip.weights = WeightSequence(3, 2);
    clip.markers = PointSequence(3, 30);
    clip.gaze.resize(3);
    for (std::uint32_t m = 0; m < 30; ++m) clip.marker_sites.push_back(Site::at_vertex(m * 7));
    std::srand(77);
    for (const char* name : {"JawOpen", "MouthSmile"}) {
        clip.blendshapes.push_back({name, Points::Random(V, 3)});
        clip.blendshapes.back().offsets.bottomRows(12).setZero();
    }
    for (std::int64_t f = 0; f < 3; ++f) {
        clip.vertices->frame(f) = clip.neutral->positions + 0.1f * float(take + 1) * float(f) * clip.blendshapes[0].offsets;
        for (std::uint32_t m = 0; m < 30; ++m) clip.markers->frame(f).row(m) = clip.vertices->frame(f).row(m * 7);
        clip.weights->frame(f)[0] = 0.1f * float(take + 1) * float(f);
    }
    return clip;
}

Clip of_kind(Clip clip, MotionKind kind) {
    if (kind != MotionKind::vertices) clip.vertices.reset();
    if (kind != MotionKind::markers) clip.markers.reset();
    if (kind != MotionKind::weights) clip.weights.reset();
    return clip;
}

Result<model::FaceModel> decode(const encoder::EncodedModel& encoded) {
    return decoder::decode_model(encoded.manifest, [&](const Hash& hash) -> const Bytes* {
        for (const auto& blob : encoded.blobs)
            if (blob.hash == hash) return &blob.bytes;
        return nullptr;
    });
}

void expect_same(const model::FaceModel& a, const model::FaceModel& b) {
    EXPECT_EQ(a.neutral.positions, b.neutral.positions);
    EXPECT_EQ(a.neutral.triangles, b.neutral.triangles);
    EXPECT_EQ(a.neutral.texcoords, b.neutral.texcoords);
    EXPECT_EQ(a.neutral.texcoord_triangles, b.neutral.texcoord_triangles);
    ASSERT_EQ(a.neutral.parts.size(), b.neutral.parts.size());
    for (std::size_t i = 0; i < a.neutral.parts.size(); ++i) EXPECT_EQ(a.neutral.parts[i].name, b.neutral.parts[i].name);
    EXPECT_EQ(a.video_albedo, b.video_albedo);
    for (int side = 0; side < 2; ++side) {
        ASSERT_EQ(a.eyes[side].has_value(), b.eyes[side].has_value());
        if (!a.eyes[side]) continue;
        EXPECT_EQ(a.eyes[side]->centre, b.eyes[side]->centre);
        EXPECT_EQ(a.eyes[side]->vertices, b.eyes[side]->vertices);
    }
    ASSERT_EQ(a.contacts.size(), b.contacts.size());
    for (std::size_t c = 0; c < a.contacts.size(); ++c) {
        EXPECT_EQ(a.contacts[c].pairs, b.contacts[c].pairs);
        ASSERT_EQ(a.contacts[c].members.size(), b.contacts[c].members.size());
        for (std::size_t i = 0; i < a.contacts[c].members.size(); ++i) {
            EXPECT_EQ(a.contacts[c].members[i].vertex, b.contacts[c].members[i].vertex);
            EXPECT_EQ(a.contacts[c].members[i].hold, b.contacts[c].members[i].hold);
        }
    }
    ASSERT_EQ(a.lids.size(), b.lids.size());
    for (std::size_t l = 0; l < a.lids.size(); ++l) {
        EXPECT_EQ(a.lids[l].centre, b.lids[l].centre);
        ASSERT_EQ(a.lids[l].members.size(), b.lids[l].members.size());
        for (std::size_t i = 0; i < a.lids[l].members.size(); ++i) {
            EXPECT_EQ(a.lids[l].members[i].vertex, b.lids[l].members[i].vertex);
            EXPECT_EQ(a.lids[l].members[i].share, b.lids[l].members[i].share);
            EXPECT_EQ(a.lids[l].members[i].weight, b.lids[l].members[i].weight);
            EXPECT_EQ(a.lids[l].members[i].hold, b.lids[l].members[i].hold);
        }
    }
    ASSERT_EQ(a.base.index(), b.base.index());
    if (const auto* blend = std::get_if<model::BlendBase>(&a.base)) {
        const auto& other = std::get<model::BlendBase>(b.base);
        EXPECT_EQ(blend->markers, other.markers);
        EXPECT_EQ(blend->row_start, other.row_start);
        ASSERT_EQ(blend->terms.size(), other.terms.size());
        for (std::size_t i = 0; i < blend->terms.size(); ++i) {
            EXPECT_EQ(blend->terms[i].marker, other.terms[i].marker);
            EXPECT_EQ(blend->terms[i].weight, other.terms[i].weight);
        }
    } else if (const auto* shapes = std::get_if<model::BlendshapeBase>(&a.base)) {
        const auto& other = std::get<model::BlendshapeBase>(b.base);
        ASSERT_EQ(shapes->targets.size(), other.targets.size());
        for (std::size_t i = 0; i < shapes->targets.size(); ++i) {
            EXPECT_EQ(shapes->targets[i].name, other.targets[i].name);
            EXPECT_EQ(shapes->targets[i].offsets, other.targets[i].offsets);
        }
    } else if (const auto* points = std::get_if<model::PointBase>(&a.base)) {
        EXPECT_EQ(points->markers, std::get<model::PointBase>(b.base).markers);
        EXPECT_EQ(points->triangulation, std::get<model::PointBase>(b.base).triangulation);
    }
}

class ModelCodec : public testing::TestWithParam<MotionKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, ModelCodec, testing::Values(MotionKind::vertices, MotionKind::markers, MotionKind::weights));

TEST_P(ModelCodec, TheDecoderHasTheModelThatTheEncoderForesaw) {
    for (const float step : {1.0f / 32, 0.03f}) {
        const auto encoded = encoder::encode_model(of_kind(small_clip(), GetParam()), {GetParam(), encoder::Albedo::none, step});
        ASSERT_TRUE(encoded.ok()) << encoded.error().message;
        const auto decoded = decode(*encoded);
        ASSERT_TRUE(decoded.ok()) << decoded.error().message;
        expect_same(encoded->model, *decoded);
        EXPECT_LE((decoded->neutral.positions - small_head().positions).cwiseAbs().maxCoeff(), step / 2 * 1.001f);
        EXPECT_EQ(decoded->eyes[0].has_value(), GetParam() != MotionKind::vertices) << "vertex motion carries its own gaze";
        for (const auto& blob : encoded->blobs) EXPECT_EQ(blob.hash, sha256(blob.bytes));
        EXPECT_EQ(encoded->blobs.front().hash, encoded->manifest);
    }
}

TEST_P(ModelCodec, AnotherClipOfTheActorNamesTheSameBlobs) {
    const auto first = encoder::encode_model(of_kind(small_clip(0), GetParam()), {GetParam(), encoder::Albedo::none});
    const auto second = encoder::encode_model(of_kind(small_clip(9), GetParam()), {GetParam(), encoder::Albedo::none});
    ASSERT_TRUE(first.ok() && second.ok());
    EXPECT_EQ(first->manifest, second->manifest);
    Clip other = of_kind(small_clip(9), GetParam());
    other.neutral->positions(3, 1) += 1;
    const auto third = encoder::encode_model(other, {GetParam(), encoder::Albedo::none});
    ASSERT_TRUE(third.ok());
    EXPECT_NE(first->manifest, third->manifest);
}

TEST_P(ModelCodec, DamagedManifestsAndMissingBlobsAreRefused) {
    const auto encoded = encoder::encode_model(of_kind(small_clip(), GetParam()), {GetParam(), encoder::Albedo::none});
    ASSERT_TRUE(encoded.ok());
    for (std::size_t without = 0; without < encoded->blobs.size(); ++without) {
        encoder::EncodedModel lacking = *encoded;
        lacking.blobs.erase(lacking.blobs.begin() + long(without));
        const auto decoded = decode(lacking);
        ASSERT_FALSE(decoded.ok());
        EXPECT_EQ(decoded.error().code, ErrorCode::missing);
    }
}

TEST(ModelCodec, MarkersAloneBecomeATriangulatedCloud) {
    Clip clip = of_kind(small_clip(), MotionKind::markers);
    clip.neutral.reset();
    clip.marker_sites.clear();
    clip.blendshapes.clear();
    const auto encoded = encoder::encode_model(clip, {MotionKind::markers, encoder::Albedo::none});
    ASSERT_TRUE(encoded.ok()) << encoded.error().message;
    const auto decoded = decode(*encoded);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    expect_same(encoded->model, *decoded);
    EXPECT_EQ(decoded->point_count(), 30);
    EXPECT_FALSE(std::get<model::PointBase>(decoded->base).triangulation.empty());
}

TEST(ModelCodec, ClipsThatCannotDriveTheModelAreRefusedWithAReason) {
    const auto refused = [](Clip clip, MotionKind kind, float step = 1.0f / 32) {
        const auto encoded = encoder::encode_model(clip, {kind, encoder::Albedo::none, step});
        return encoded.ok() ? ErrorCode::unavailable : encoded.error().code;
    };
    Clip no_mesh = small_clip();
    no_mesh.neutral.reset();
    EXPECT_EQ(refused(no_mesh, MotionKind::vertices), ErrorCode::missing);
    Clip no_sites = small_clip();
    no_sites.marker_sites.clear();
    EXPECT_EQ(refused(no_sites, MotionKind::markers), ErrorCode::missing);
    Clip few_sites = small_clip();
    few_sites.marker_sites.resize(3);
    EXPECT_EQ(refused(few_sites, MotionKind::markers), ErrorCode::invalid);
    Clip far = small_clip();
    far.neutral->positions.col(2).array() += 1e6f;
    EXPECT_EQ(refused(far, MotionKind::vertices, 1.0f / 4096), ErrorCode::invalid);
}

TEST(ModelDecoder, RefusesLayersThatDoNotBuildOnEachOther) {
    const auto markers = encoder::encode_model(of_kind(small_clip(), MotionKind::markers), {MotionKind::markers, encoder::Albedo::none});
    ASSERT_TRUE(markers.ok());
    const auto manifest = protocol::parse_manifest(markers->blobs.front().bytes);
    ASSERT_TRUE(manifest.ok());
    ASSERT_EQ(manifest->layers.size(), 3u);
    const protocol::Layer shape = manifest->layers[0], blend = manifest->layers[1], eyes = manifest->layers[2];
    protocol::Layer points = shape;
    points.kind = LayerKind::points;
    points.blobs.resize(2);
    const Bytes lid_bytes[] = {coding::encode_lid({Vec3(7, 20, -4), {{3, 1, 1, 1}}}), coding::encode_lid({Vec3(21, 20, -4), {{4, 1, 1, 1}}})};
    const Bytes contact_bytes = coding::encode_contact({{{3, 4}}, {{3, 1}}});
    const protocol::Layer lid{LayerKind::lid, {sha256(lid_bytes[0])}}, other_lid{LayerKind::lid, {sha256(lid_bytes[1])}};
    const protocol::Layer contact{LayerKind::contact, {sha256(contact_bytes)}};
    const auto accepts = [&](std::vector<protocol::Layer> layers) {
        encoder::EncodedModel other = *markers;
        for (const Bytes& bytes : lid_bytes) other.blobs.push_back({sha256(bytes), protocol::BlobKind::lid, bytes});
        other.blobs.push_back({sha256(contact_bytes), protocol::BlobKind::contact, contact_bytes});
        const Bytes bytes = protocol::encode_manifest({"", std::move(layers)});
        other.manifest = sha256(bytes);
        other.blobs.push_back({other.manifest, protocol::BlobKind::manifest, bytes});
        return decode(other).ok();
    };
    EXPECT_TRUE(accepts({shape, blend, eyes}));
    EXPECT_TRUE(accepts({shape, eyes, blend}));
    EXPECT_TRUE(accepts({points}));
    EXPECT_FALSE(accepts({blend, shape}));
    EXPECT_FALSE(accepts({eyes, shape}));
    EXPECT_FALSE(accepts({shape, blend, shape}));
    EXPECT_FALSE(accepts({shape, blend, blend}));
    EXPECT_FALSE(accepts({shape, points}));
    EXPECT_FALSE(accepts({shape, eyes, points}));
    EXPECT_FALSE(accepts({points, eyes}));
    EXPECT_TRUE(accepts({shape, blend, lid, other_lid}));
    EXPECT_TRUE(accepts({shape, lid, blend}));
    EXPECT_FALSE(accepts({lid, shape}));
    EXPECT_FALSE(accepts({points, lid}));
    EXPECT_FALSE(accepts({shape, blend, lid, lid})) << "a vertex of two lids";
    std::vector<protocol::Layer> layers(10, contact);
    layers[0] = shape, layers[1] = blend;
    EXPECT_TRUE(accepts(layers)) << "eight contacts";
    layers.push_back(contact);
    EXPECT_FALSE(accepts(layers));
}

TEST(ModelDecoder, KnowsWhichMotionDrivesAModel) {
    for (const MotionKind kind : {MotionKind::vertices, MotionKind::markers, MotionKind::weights}) {
        const auto encoded = encoder::encode_model(of_kind(small_clip(), kind), {kind, encoder::Albedo::none});
        ASSERT_TRUE(encoded.ok());
        const std::map<MotionKind, std::uint32_t> counts = {{MotionKind::vertices, 237}, {MotionKind::markers, 30}, {MotionKind::weights, 2}};
        for (const auto& [other, count] : counts) {
            protocol::MotionInfo info;
            info.kind = other;
            info.count = count;
            EXPECT_EQ(decoder::fits(encoded->model, info), other == kind);
            info.count = count + 1;
            EXPECT_FALSE(decoder::fits(encoded->model, info));
        }
    }
}

TEST(ShapeStep, AddsLessThanATenthToTheSquareOfTheAskedError) {
    for (const double rms : {0.005, 0.02, 0.1, 0.3}) {
        const double step = encoder::shape_step(rms);
        EXPECT_LE(step * step / 4, 0.1 * rms * rms * 1.0001);
        EXPECT_GT(4 * step * step / 4, 0.1 * rms * rms) << "twice the step would be too coarse";
        EXPECT_EQ(step, std::exp2(std::round(std::log2(step))));
    }
}

}  // namespace
}  // namespace mien
