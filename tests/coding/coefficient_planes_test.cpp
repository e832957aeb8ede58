#include "coding/coefficient_planes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace mien::coding {
namespace {

struct Field {
    TexelMask mask{40, 24, std::vector<std::uint8_t>(960, 1)};
    MaskedWavelet wavelet;
    std::vector<std::int32_t> truth;  // three planes, sparse and with long tails, together where they are large

    Field() : wavelet((mask.set[17] = 0, mask.set[500] = 0, mask)) {
        std::mt19937 random(7);
        std::normal_distribution<double> normal;
        for (int p = 0; p < 3; ++p)
            for (std::uint32_t i = 0; i < wavelet.size(); ++i) truth.push_back(std::int32_t(std::exp2(6 * std::sin(i * 0.02) - p) * normal(random)));
    }
};

TEST(CoefficientPlanes, ComeBackStageByStage) {
    const Field field;
    for (const int stages : {1, 4}) {
        CoefficientPlanes in(field.wavelet, 3), out(field.wavelet, 3);
        for (int stage = 0; stage < stages; ++stage) {
            const int below = stages - 1 - stage;
            ASSERT_TRUE(out.decode(in.encode(field.truth, below)));
            for (int p = 0; p < 3; ++p)
                for (std::uint32_t i = 0; i < field.wavelet.size(); ++i) {
                    const std::int32_t t = field.truth[std::size_t(p) * field.wavelet.size() + i];
                    ASSERT_EQ(out.plane(p)[i], (t < 0 ? -1 : 1) * (std::abs(t) >> below)) << stage;
                }
        }
    }
}

TEST(CoefficientPlanes, StagesCostLittleMoreThanAllAtOnce) {
    const Field field;
    const auto bytes = [&](int stages) {
        CoefficientPlanes planes(field.wavelet, 3);
        std::size_t sum = 0;
        for (int stage = 0; stage < stages; ++stage) sum += planes.encode(field.truth, stages - 1 - stage).size();
        return double(sum);
    };
    EXPECT_LT(bytes(4), 1.15 * bytes(1)) << "of so few coefficients; one in a hundred of a face's";
}

TEST(CoefficientPlanes, RefuseDamage) {
    const Field field;
    CoefficientPlanes in(field.wavelet, 3);
    const Bytes first = in.encode(field.truth, 2), second = in.encode(field.truth, 1);
    // The coder sees zeros behind the end, which now and then decode to something short enough.
    std::size_t refused = 0, cuts = 0;
    for (std::size_t size = 0; size + 8 < first.size(); size += 5, ++cuts) refused += !CoefficientPlanes(field.wavelet, 3).decode(ByteView(first).first(size));
    EXPECT_GT(refused, cuts * 9 / 10);
    Bytes longer = first;
    longer.insert(longer.end(), 8, std::byte{1});
    EXPECT_FALSE(CoefficientPlanes(field.wavelet, 3).decode(longer));
    std::mt19937 random(4);
    for (int run = 0; run < 200; ++run) {
        Bytes a = first, b = second;
        a[random() % a.size()] ^= std::byte(1 + random() % 255);
        b[random() % b.size()] ^= std::byte(1 + random() % 255);
        CoefficientPlanes planes(field.wavelet, 3);
        planes.decode(a);
        planes.decode(b);
        for (int p = 0; p < 3; ++p)
            for (std::uint32_t i = 0; i < field.wavelet.size(); ++i) ASSERT_LE(std::abs(planes.plane(p)[i]), CoefficientPlanes::kMaxValue);
    }
}

}  // namespace
}  // namespace mien::coding
