#include "coding/masked_wavelet.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace mien::coding {
namespace {

/// A disc with a slit, a ragged edge and texels on their own.
TexelMask ragged(int width, int height) {
    TexelMask mask{width, height, std::vector<std::uint8_t>(std::size_t(width) * std::size_t(height))};
    std::mt19937 random(3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float dx = float(x) / float(width) - 0.5f, dy = float(y) / float(height) - 0.5f, r = std::sqrt(dx * dx + dy * dy);
            const bool slit = std::abs(dy) < 0.03f && dx > -0.2f;
            mask.set[std::size_t(y) * std::size_t(width) + std::size_t(x)] = (r < 0.4f && !slit && (r < 0.36f || random() % 2)) || random() % 97 == 0;
        }
    return mask;
}

std::size_t count(const TexelMask& mask) { return std::size_t(std::accumulate(mask.set.begin(), mask.set.end(), 0)); }

TEST(MaskedWavelet, HasAsManyCoefficientsAsTexelsAndGivesThemBack) {
    for (const auto& [width, height] : {std::pair(64, 64), {61, 37}, {8, 8}, {1, 40}, {9, 1}}) {
        const TexelMask mask = ragged(width, height);
        const MaskedWavelet wavelet(mask);
        ASSERT_EQ(wavelet.size(), count(mask));
        std::uint32_t in_bands = 0;
        for (const auto& band : wavelet.bands()) {
            EXPECT_EQ(band.first, in_bands);
            in_bands += band.count;
        }
        EXPECT_EQ(in_bands, wavelet.size());
        std::mt19937 random(1);
        std::vector<float> samples(wavelet.size()), coefficients(samples.size()), back(samples.size());
        for (float& s : samples) s = float(random() % 2001) / 1000 - 1;
        wavelet.forward(samples.data(), coefficients.data());
        wavelet.inverse(coefficients.data(), back.data());
        for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_NEAR(back[i], samples[i], 1e-5f) << width << ' ' << height;
    }
}

TEST(MaskedWavelet, AConstantHasNoDetailAndErrorsWeighAboutAlike) {
    const TexelMask mask = ragged(96, 80);
    const MaskedWavelet wavelet(mask);
    std::vector<float> samples(wavelet.size(), 1), coefficients(samples.size());
    wavelet.forward(samples.data(), coefficients.data());
    const std::uint32_t low = wavelet.bands().front().count;
    for (std::uint32_t i = low; i < wavelet.size(); ++i) EXPECT_NEAR(coefficients[i], 0, 1e-3f);
    // White noise in the coefficients is noise of nearly the same power in the texels.
    std::mt19937 random(2);
    std::normal_distribution<float> normal;
    double in = 0, out = 0;
    for (int run = 0; run < 20; ++run) {
        for (float& c : coefficients) {
            c = normal(random);
            in += double(c) * c;
        }
        wavelet.inverse(coefficients.data(), samples.data());
        for (const float s : samples) out += double(s) * s;
    }
    EXPECT_NEAR(out / in, 1, 0.08);
}

TEST(MaskedWavelet, KnowsWhatLiesAroundACoefficient) {
    const TexelMask full{32, 32, std::vector<std::uint8_t>(1024, 1)};
    const MaskedWavelet wavelet(full);
    ASSERT_EQ(wavelet.bands().size(), 7u);
    const auto& band = wavelet.bands().back();  // 16 x 16, both
    EXPECT_EQ(band.level, 0);
    EXPECT_EQ(band.orientation, 3);
    const auto around = wavelet.around(band);
    const auto& middle = around[5 * 16 + 7];
    const std::uint32_t at = band.first + 5 * 16 + 7;
    const std::uint32_t expected[8] = {at - 1, at + 1, at - 16, at + 16, at - 17, at - 15, at + 15, at + 17};
    for (int k = 0; k < 8; ++k) EXPECT_EQ(middle.at[k], expected[k]) << k;
    EXPECT_EQ(middle.parent, wavelet.bands()[3].first + 2 * 8 + 3);
    EXPECT_EQ(around[0].at[0], MaskedWavelet::kNone);
    EXPECT_EQ(wavelet.around(wavelet.bands()[0])[0].parent, MaskedWavelet::kNone);
}

TEST(TexelMaskCode, KeepsAMaskAndRefusesSizesThatCannotBe) {
    const TexelMask mask = ragged(61, 37);
    const Bytes bytes = encode_mask(mask);
    const auto back = decode_mask(bytes);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->width, 61);
    EXPECT_EQ(back->set, mask.set);
    for (std::size_t size = 0; size < bytes.size() / 2; ++size) EXPECT_FALSE(decode_mask(ByteView(bytes).first(size)).ok()) << size;
    const auto announce = [](std::uint64_t width, std::uint64_t height, int rest) {
        ByteWriter out;
        out.varint(width);
        out.varint(height);
        for (int i = 0; i < rest; ++i) out.u8(0);
        return decode_mask(out.view());
    };
    ASSERT_FALSE(announce(4097, 1, 0).ok());
    EXPECT_EQ(announce(4097, 1, 0).error().code, ErrorCode::limit_exceeded);
    EXPECT_EQ(announce(4096, 4096, 8).error().code, ErrorCode::limit_exceeded) << "sixteen million texels in eight bytes";
    EXPECT_EQ(announce(0, 5, 1).error().code, ErrorCode::damaged);
    const TexelMask full{4096, 512, std::vector<std::uint8_t>(std::size_t(4096) * 512, 1)};
    EXPECT_TRUE(decode_mask(encode_mask(full)).ok()) << "but a map that is all face may be so short";
}

}  // namespace
}  // namespace mien::coding
