#include <gtest/gtest.h>

#include <map>

#include "coding/detail_code.hpp"
#include "coding/mesh_code.hpp"
#include "coding/texel_mask.hpp"
#include "decoder/detail_decoder.hpp"
#include "decoder/detail_limits.hpp"
#include "encoder/detail_encoder.hpp"
#include "protocol/messages.hpp"
#include "tests/detail/small_model.hpp"

namespace mien {
namespace {

using protocol::BlobKind;
using protocol::LayerKind;

/// A stored model whose parts can be exchanged.
struct Parts {
    std::map<Hash, Bytes> blobs;
    protocol::Manifest manifest;

    Parts() {
        const SmallModel small(14, 12);
        auto coded = encoder::encode_detail(small.model, small.moments, "sheet", {.medium = 0.05, .fine = 0.01, .albedo = 0.01, .stages = 2});
        for (const auto& blob : coded->blobs) blobs[blob.hash] = blob.bytes;
        manifest = *protocol::parse_manifest(blobs[coded->manifest]);
    }
    protocol::Layer& layer(LayerKind kind) {
        return *std::find_if(manifest.layers.begin(), manifest.layers.end(), [&](const auto& l) { return l.kind == kind; });
    }
    Bytes& blob(LayerKind kind, std::size_t i) { return blobs[layer(kind).blobs[i]]; }
    Result<model::DetailModel> decode() const {
        const Bytes bytes = protocol::encode_manifest(manifest);
        const Hash name = sha256(bytes);
        return decoder::decode_detail(name, [&](const Hash& hash) -> const Bytes* {
            if (hash == name) return &bytes;
            const auto found = blobs.find(hash);
            return found == blobs.end() ? nullptr : &found->second;
        });
    }
};

void expect_refused(const Parts& parts, ErrorCode code) {
    const auto model = parts.decode();
    ASSERT_FALSE(model.ok());
    EXPECT_EQ(model.error().code, code) << model.error().message;
    EXPECT_FALSE(model.error().message.empty());
}

TEST(HostileModel, LayersBuildOnEachOtherAndStandOnce) {
    ASSERT_TRUE(Parts().decode().ok());
    Parts twice;
    twice.manifest.layers.push_back(twice.layer(LayerKind::fine));
    expect_refused(twice, ErrorCode::damaged);
    Parts early;
    std::swap(early.manifest.layers[0], early.manifest.layers[1]);
    expect_refused(early, ErrorCode::damaged);
    Parts without_markers;
    without_markers.manifest.layers.resize(2);
    expect_refused(without_markers, ErrorCode::invalid);
    Parts more_stages;
    auto& fine = more_stages.layer(LayerKind::fine).blobs;
    fine.push_back(fine.back());
    expect_refused(more_stages, ErrorCode::damaged);
    Parts no_map;
    no_map.layer(LayerKind::medium).blobs.resize(1);
    expect_refused(no_map, ErrorCode::damaged);
    Parts other_mask;
    other_mask.layer(LayerKind::albedo_map).blobs[0] = other_mask.layer(LayerKind::medium).blobs[0];
    expect_refused(other_mask, ErrorCode::damaged);
}

TEST(HostileModel, HugeMapsOfFewBytesAreRefusedBeforeTheyAreAllocated) {
    Parts parts;
    const coding::TexelMask full{2048, 2048, std::vector<std::uint8_t>(std::size_t(2048) * 2048, 1)};
    parts.blob(LayerKind::medium, 0) = coding::encode_mask(full);
    expect_refused(parts, ErrorCode::limit_exceeded);
    Parts wrong;
    wrong.blob(LayerKind::medium, 1)[0] = std::byte{1};
    EXPECT_FALSE(wrong.decode().ok()) << "one channel";
    Parts order;
    order.blob(LayerKind::medium, 1)[1] = std::byte{3};
    expect_refused(order, ErrorCode::damaged);
}

TEST(HostileModel, MarkersThatAreJoinedAcrossAndAcrossAreRefused) {
    Parts parts;
    auto domain = coding::decode_marker_domain(parts.blob(LayerKind::marker_domain, 0), 36);
    ASSERT_TRUE(domain.ok());
    domain->triangles.clear();
    std::uint32_t seed = 1;
    while (domain->triangles.size() < 30'000) {
        seed = seed * 1664525 + 1013904223;
        const Triangle t = {seed >> 8 & 31, seed >> 16 & 31, seed >> 24 & 31};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) domain->triangles.push_back(t);
    }
    parts.blob(LayerKind::marker_domain, 0) = coding::encode_marker_domain(*domain);
    expect_refused(parts, ErrorCode::limit_exceeded);
}

TEST(HostileModel, SkinThatNoSolverShouldMeetIsRefused) {
    Mesh fan;  // all triangles meet in one vertex
    constexpr std::uint32_t kRim = 20'000;
    fan.positions = Points::Random(kRim + 1, 3);
    for (std::uint32_t v = 1; v < kRim; ++v) fan.triangles.push_back({0, v, v + 1});
    EXPECT_FALSE(decoder::check_skin(fan, 3).ok());
    Mesh tangle;  // random triangles: every edge leads elsewhere
    tangle.positions = Points::Random(3000, 3);
    std::uint32_t seed = 1;
    const auto next = [&] { return (seed = seed * 1664525 + 1013904223) >> 8; };
    for (int t = 0; t < 6000; ++t) tangle.triangles.push_back({next() % 3000, next() % 3000, next() % 3000});
    const auto refused = decoder::check_skin(tangle, 3);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::limit_exceeded);
    const Mesh sheet = analysis::sheet();
    EXPECT_TRUE(decoder::check_skin(sheet, 36).ok());
    EXPECT_FALSE(decoder::check_skin(sheet, std::size_t(1) << 20).ok()) << "vertices times markers";
    Mesh piled = sheet;
    for (std::size_t i = 0; i < piled.texcoords.size(); ++i) piled.texcoords[i] = Vec2(i % 2 ? -3.0f : 4.0f, i % 3 ? -3.0f : 4.0f);
    EXPECT_FALSE(decoder::check_domain(piled, {}, 36, 4096, 4096, 1).ok()) << "texture triangles over the whole map, some hundred times";
}

TEST(HostileModel, DamagedBlobsAreRefusedOrGiveFiniteModels) {
    const Parts good;
    std::size_t refused = 0;
    for (const auto& [hash, bytes] : good.blobs) {
        const std::size_t stride = bytes.size() / 12 + 1;
        for (std::size_t at = 0; at < bytes.size(); at += stride)
            for (const bool cut : {true, false}) {
                Parts parts = good;
                Bytes& blob = parts.blobs[hash];
                if (cut) blob.resize(at);
                else blob[at] ^= std::byte(0x21);
                const auto model = parts.decode();
                if (!model.ok()) {
                    ++refused;
                    continue;
                }
                for (const model::PolynomialMap* map : {&model->medium, &model->fine, &model->albedo})
                    for (const float c : map->planes) ASSERT_TRUE(std::isfinite(c));
                ASSERT_EQ(model->medium.texels, model->medium_domain.size());
                for (const Triangle& t : model->marker_triangles)
                    for (const std::uint32_t m : t) ASSERT_LT(m, model->sites.size());
            }
    }
    EXPECT_GT(refused, 150u);
}

}  // namespace
}  // namespace mien
