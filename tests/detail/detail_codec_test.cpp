#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>

#include "coding/detail_code.hpp"
#include "core/parallel.hpp"
#include "decoder/detail_decoder.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/mesh_blobs.hpp"
#include "protocol/messages.hpp"
#include "tests/detail/small_model.hpp"

namespace mien {
namespace {

/// Added RMS of every layer over the frames of a clip, as the encoder means it: medium, fine, albedo.
std::array<double, 3> added_errors(const Clip& clip, const model::DetailModel& truth, const model::DetailModel& stored) {
    std::array<double, 3> errors{};
    const auto driver = [](const model::DetailModel& m) { return model::MarkerDriver(m.neutral, m.sites, m.fixed, m.marker_triangles); };
    const model::MarkerDriver a = driver(truth), b = driver(stored);
    for (std::int64_t f = 0; f < clip.markers->frames; ++f) {
        const auto at = a.drive(clip.markers->frame(f), truth.axes).parameters, bt = b.drive(clip.markers->frame(f), stored.axes).parameters;
        const auto add = [&](std::size_t layer, const model::PolynomialMap& x, const model::DomainMap& xd, const model::PolynomialMap& y, const model::DomainMap& yd) {
            std::vector<float> xs(std::size_t(x.channels) * x.texels), ys(std::size_t(y.channels) * y.texels);
            model::evaluate_plain(x, xd, at, xs.data());
            model::evaluate_plain(y, yd, bt, ys.data());
            const FloatMap xm = model::spread(xd, x.channels, xs.data()), ym = model::spread(yd, y.channels, ys.data());
            double sum = 0;
            for (const std::uint32_t place : yd.place)
                for (int c = 0; c < x.channels; ++c) {
                    const double e = double(xm.values[place * std::size_t(x.channels) + std::size_t(c)]) - double(ym.values[place * std::size_t(x.channels) + std::size_t(c)]);
                    sum += e * e;
                }
            errors[layer] += sum / double(yd.size()) / double(clip.markers->frames);
        };
        add(0, truth.medium, truth.medium_domain, stored.medium, stored.medium_domain);
        add(1, truth.fine, truth.fine_domain, stored.fine, stored.fine_domain);
        add(2, truth.albedo, truth.fine_domain, stored.albedo, stored.fine_domain);
    }
    for (double& e : errors) e = std::sqrt(e);
    return errors;
}

/// Blobs by their names.
struct Store {
    std::map<Hash, Bytes> blobs;
    Hash manifest;
    explicit Store(const encoder::EncodedDetail& detail) : manifest(detail.manifest) {
        for (const auto& blob : detail.blobs) blobs[blob.hash] = blob.bytes;
    }
    Result<model::DetailModel> decode() const {
        return decoder::decode_detail(manifest, [&](const Hash& hash) {
            const auto found = blobs.find(hash);
            return found == blobs.end() ? nullptr : &found->second;
        });
    }
};

const encoder::DetailOptions kOptions{.medium = 0.02, .fine = 0.004, .albedo = 0.003};

TEST(DetailCodec, KeepsTheAskedErrorOverTheTrainingFrames) {
    const SmallModel small;
    const auto coded = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    ASSERT_TRUE(coded.ok()) << coded.error().message;
    const auto back = Store(*coded).decode();
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_GE(back->medium_domain.size() + 2, small.model.medium_domain.size()) << "rounding the mesh may lose a texel at its border";
    EXPECT_EQ(back->medium_domain.place, coded->model.medium_domain.place);
    EXPECT_EQ(back->fine_domain.b1, coded->model.fine_domain.b1);
    const auto errors = added_errors(small.clip, small.model, *back);
    // A fifth more: factors are interpolated between markers, and the wavelet is orthonormal only nearly.
    EXPECT_LT(errors[0], 1.2 * kOptions.medium);
    EXPECT_LT(errors[1], 1.2 * kOptions.fine);
    EXPECT_LT(errors[2], 1.2 * kOptions.albedo);
    EXPECT_GT(errors[0], 0.3 * kOptions.medium) << "bytes are spent on less error than was asked for";
}

TEST(DetailCodec, CodesAnyOrderAndModelsOfFewerLayers) {
    for (const auto order : {model::PolynomialOrder::constant, model::PolynomialOrder::linear, model::PolynomialOrder::bicubic}) {
        SmallModel small(17, 20, order);
        small.model.albedo = {};
        if (order == model::PolynomialOrder::linear) {
            small.model.medium = {};
            small.model.medium_domain = {};
        }
        const auto coded = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
        ASSERT_TRUE(coded.ok()) << coded.error().message;
        const auto back = Store(*coded).decode();
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_EQ(back->fine.order, order);
        EXPECT_EQ(back->albedo.texels, 0u);
        EXPECT_EQ(back->medium.texels, coded->model.medium.texels);
        const float middle = small.model.fine.plane(0, 0)[small.model.fine.texels / 2];
        const auto place = small.model.fine_domain.place[small.model.fine.texels / 2];
        const auto found = std::find(back->fine_domain.place.begin(), back->fine_domain.place.end(), place);
        ASSERT_NE(found, back->fine_domain.place.end());
        EXPECT_NEAR(back->fine.plane(0, 0)[found - back->fine_domain.place.begin()], middle, 10 * kOptions.fine);
    }
}

/// What training goes by: it is the mesh of the decoders to the bit.
TEST(DetailCodec, AMeshAsStoredIsStoredAsItIs) {
    const SmallModel small;
    const float step = kOptions.mesh_step;
    const auto once = encoder::mesh_as_stored(small.model.neutral, step);
    ASSERT_TRUE(once.ok()) << once.error().message;
    EXPECT_NE(once->positions, small.model.neutral.positions);
    EXPECT_LE((once->positions - small.model.neutral.positions).cwiseAbs().maxCoeff(), 0.5001f * step);
    const auto again = encoder::mesh_as_stored(*once, step);
    ASSERT_TRUE(again.ok()) << again.error().message;
    EXPECT_EQ(again->positions, once->positions);
    EXPECT_EQ(again->texcoords, once->texcoords);
}

TEST(DetailCodec, MoreRefinementsBringItNearer) {
    const SmallModel small;
    const auto coded = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    ASSERT_TRUE(coded.ok());
    const Store whole(*coded);
    Store part = whole;
    part.blobs.clear();
    std::array<double, 3> before{1e9, 1e9, 1e9};
    int steps = 0;
    for (const auto& blob : coded->blobs) {
        part.blobs[blob.hash] = blob.bytes;
        const auto model = part.decode();
        if (blob.kind == protocol::BlobKind::detail_map || blob.kind == protocol::BlobKind::refinement) {
            ASSERT_TRUE(model.ok()) << model.error().message;
            if (model->albedo.texels == 0) continue;
            const auto errors = added_errors(small.clip, small.model, *model);
            for (std::size_t l = 0; l < 3; ++l) EXPECT_LE(errors[l], 1.01 * before[l]);
            before = errors;
            ++steps;
        }
    }
    EXPECT_EQ(steps, 3 * kOptions.stages - 2) << "first stages of all three, then the refinements of each";
    // A hole in the middle of a map's refinements: what lies behind it waits.
    const auto third = std::find_if(coded->blobs.rbegin(), coded->blobs.rend(), [](const auto& b) { return b.kind == protocol::BlobKind::refinement && b.bytes[0] == std::byte{2}; });
    part = whole;
    part.blobs.erase(third->hash);
    const auto model = part.decode();
    ASSERT_TRUE(model.ok());
    EXPECT_GT(added_errors(small.clip, small.model, *model)[2], 2 * before[2]);
}

TEST(DetailCodec, GrowsBlobByBlobIntoTheSameModel) {
    const SmallModel small;
    const auto coded = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    ASSERT_TRUE(coded.ok());
    std::map<Hash, Bytes> here;
    const auto find = [&](const Hash& hash) {
        const auto found = here.find(hash);
        return found == here.end() ? nullptr : &found->second;
    };
    std::optional<decoder::DetailDecoder> growing;
    int changes = 0;
    for (const auto& blob : coded->blobs) {
        here[blob.hash] = blob.bytes;
        if (!growing) {
            auto opened = decoder::DetailDecoder::open(coded->manifest, find);
            EXPECT_EQ(opened.ok(), blob.kind == protocol::BlobKind::marker_domain);
            if (opened.ok()) growing = std::move(*opened);
            continue;
        }
        EXPECT_FALSE(growing->complete());
        const auto changed = growing->update(find);
        ASSERT_TRUE(changed.ok());
        const bool map = blob.kind == protocol::BlobKind::detail_map || blob.kind == protocol::BlobKind::refinement;
        EXPECT_EQ(changed->medium + changed->fine + changed->albedo, map ? 1 : 0);
        changes += changed->any();
    }
    ASSERT_TRUE(growing);
    EXPECT_TRUE(growing->complete());
    EXPECT_EQ(changes, 3 * kOptions.stages);
    const auto whole = Store(*coded).decode();
    EXPECT_EQ(growing->model().medium.planes, whole->medium.planes);
    EXPECT_EQ(growing->model().albedo.planes, whole->albedo.planes);
    EXPECT_EQ(growing->model().fine_domain.place, whole->fine_domain.place);
}

TEST(DetailCodec, NeedsMeshShellAndMarkersAndLeavesOutMapsThatAreNotThere) {
    const SmallModel small(16, 16);
    const auto coded = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    ASSERT_TRUE(coded.ok());
    for (const auto& blob : coded->blobs) {
        Store part(*coded);
        part.blobs.erase(blob.hash);
        const auto model = part.decode();
        const bool map = blob.kind == protocol::BlobKind::texel_mask || blob.kind == protocol::BlobKind::detail_map || blob.kind == protocol::BlobKind::refinement;
        EXPECT_EQ(model.ok(), map) << protocol::name_of(blob.kind);
        if (!model.ok()) {
            EXPECT_EQ(model.error().code, ErrorCode::missing);
        }
        if (blob.kind == protocol::BlobKind::texel_mask) {
            EXPECT_EQ(model->fine.texels * model->medium.texels, 0u);
        }
    }
}

TEST(DetailCodec, AModelFileIsAStreamWithoutTracks) {
    const SmallModel small(16, 16);
    const auto coded = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    ASSERT_TRUE(coded.ok());
    const Bytes file = encoder::model_file(coded->manifest, coded->blobs, "actor");
    const auto back = decoder::decode_detail_file(file);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->medium.planes, Store(*coded).decode()->medium.planes);
    EXPECT_FALSE(decoder::decode_detail_file({}).ok());
    for (std::size_t at = 1; at < file.size(); at += file.size() / 300 + 1) {
        const auto cut = decoder::decode_detail_file(ByteView(file).first(at));
        EXPECT_FALSE(cut.ok() && at + 200 < file.size()) << at;
        Bytes damaged = file;
        damaged[at] ^= std::byte{0x10};
        const auto other = decoder::decode_detail_file(damaged);
        if (other.ok()) {
            EXPECT_EQ(other->medium.planes, back->medium.planes) << "hashes hold what is in the model";
        }
    }
}

TEST(DetailCodec, IsTheSameForAnyNumberOfThreads) {
    const SmallModel small(24, 24);
    set_thread_count(1);
    const auto one = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    set_thread_count(3);
    const auto three = encoder::encode_detail(small.model, small.moments, "sheet", kOptions);
    set_thread_count(0);
    ASSERT_TRUE(one.ok() && three.ok());
    EXPECT_EQ(one->manifest, three->manifest) << "hashes of all blobs are in it";
}

TEST(DetailCodec, KeepsAnAskedNumberOfBytes) {
    const SmallModel small;
    encoder::DetailOptions options = kOptions;
    options.name = "an actor of the theatre";
    // What is written counts, packed and with all that goes around it.
    const auto size = [&](const encoder::EncodedDetail& detail) { return encoder::model_file(detail.manifest, detail.blobs, options.name).size(); };
    const auto free = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_TRUE(free.ok());
    options.most_bytes = size(*free) * 7 / 10;
    const auto bound = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_TRUE(bound.ok()) << bound.error().message;
    EXPECT_LE(size(*bound), options.most_bytes);
    EXPECT_GT(size(*bound), options.most_bytes * 95 / 100);
    EXPECT_GT(bound->layers[0].error, free->layers[0].error);
    // Who asks for too little is told the least that will do.
    options.most_bytes = 100;
    const auto refused = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_FALSE(refused.ok());
    options.most_bytes = std::stoul(refused.error().message.substr(refused.error().message.rfind(' ')));
    const auto least = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_TRUE(least.ok()) << least.error().message;
    EXPECT_EQ(size(*least), options.most_bytes);
    --options.most_bytes;
    EXPECT_FALSE(encoder::encode_detail(small.model, small.moments, "sheet", options).ok());
}

TEST(DetailCodec, KeepsTheBytesOfItsMapsByGivingUpStagesOfTheFineOne) {
    const SmallModel small(32, 64);
    encoder::DetailOptions options = kOptions;
    options.fine_stages = 9;
    options.fine = kOptions.fine / 16;
    options.medium = 5 * kOptions.medium;   // far less than half of both
    const auto bytes = [](const encoder::EncodedDetail::Layer& layer) { return std::accumulate(layer.stage_bytes.begin(), layer.stage_bytes.end(), std::size_t(0)); };
    const auto free = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_TRUE(free.ok());
    ASSERT_EQ(free->layers[1].stage_bytes.size(), 9u);
    options.most_shape_bytes = bytes(free->layers[0]) + bytes(free->layers[1]) / 2;
    const auto bound = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_TRUE(bound.ok());
    EXPECT_EQ(bound->layers[0].error, free->layers[0].error) << "what fits stays as it was";
    EXPECT_EQ(bound->layers[2].error, free->layers[2].error);
    EXPECT_LE(bytes(bound->layers[0]) + bytes(bound->layers[1]), options.most_shape_bytes);
    const std::size_t places = 34 * (bound->layers[0].stage_bytes.size() + bound->layers[1].stage_bytes.size());  // a stage's in the manifest
    EXPECT_GT(bytes(bound->layers[0]) + bytes(bound->layers[1]) + places, options.most_shape_bytes * 96 / 100);
    EXPECT_LT(bound->layers[1].stage_bytes.size(), 9u);
    EXPECT_LT(bound->layers[1].stage_bytes[0], free->layers[1].stage_bytes[0] * 3 / 2) << "it begins about as coarse";
    EXPECT_TRUE(Store(*bound).decode().ok());

    options.most_shape_bytes = 0;
    options.most_map_bytes = bytes(free->layers[0]) + bytes(free->layers[1]) + bytes(free->layers[2]) / 2;
    const auto all = encoder::encode_detail(small.model, small.moments, "sheet", options);
    ASSERT_TRUE(all.ok());
    EXPECT_EQ(all->layers[1].error, free->layers[1].error);
    EXPECT_LE(bytes(all->layers[0]) + bytes(all->layers[1]) + bytes(all->layers[2]), options.most_map_bytes);
}

TEST(DetailCodec, IsStoredAsFineAsItsFitIsByDefault) {
    const encoder::DetailOptions usual;
    EXPECT_EQ(encoder::detail_options(0.1).fine, usual.fine) << "never coarser than is seen";
    EXPECT_EQ(encoder::detail_options(0.1).fine_stages, usual.stages);
    EXPECT_EQ(encoder::detail_options(usual.fine / 4).fine, usual.fine / 4);
    EXPECT_EQ(encoder::detail_options(usual.fine / 4).fine_stages, usual.stages + 2);
    EXPECT_GT(encoder::detail_options(0).fine, 0) << "a fit without error";
    EXPECT_LE(encoder::detail_options(0).fine_stages, coding::kMaxStages);
}

TEST(DetailCodec, RefusesToStoreWhatIsNotFinite) {
    SmallModel small(16, 16);
    small.model.fine.planes[5] = std::nanf("");
    EXPECT_FALSE(encoder::encode_detail(small.model, small.moments, "sheet", kOptions).ok());
}

}  // namespace
}  // namespace mien
