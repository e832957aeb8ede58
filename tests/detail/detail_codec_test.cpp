#include <gtest/gtest.h>

#include <map>
#include <set>

#include "decoder/detail_decoder.hpp"
#include "encoder/detail_encoder.hpp"
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

}  // namespace
}  // namespace mien
