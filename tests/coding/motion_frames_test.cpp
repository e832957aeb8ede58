#include "coding/motion_frames.hpp"

#include <gtest/gtest.h>

#include <random>

namespace mien::coding {
namespace {

MotionBasis basis_of(int components, std::mt19937& random) {
    MotionBasis basis;
    basis.scheme = MotionScheme::causal;
    basis.components.resize(std::size_t(components));   // as many as there are; what they hold is of no account here
    basis.predictors.resize(std::size_t(components) + 6);
    for (auto& row : basis.predictors)
        for (std::int16_t& a : row) a = std::int16_t(int(random() % 301) - 150);
    return basis;
}

TEST(MotionFrames, CausalNumbersOfEverySizeComeBack) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        std::mt19937 random(seed);
        const MotionShape shape{.points = 2, .pose = true};
        const MotionBasis basis = basis_of(int(random() % 30), random);
        MotionFrames writer(basis, shape), reader(basis, shape);
        const int channels = writer.layout().total();
        for (int f = 0; f < 12; ++f) {
            writer.begin_object(1);
            RangeEncoder encoder;
            int state = 0;
            std::vector<std::int64_t> expected;
            writer.code_frame(encoder, [&](int c) {
                const std::int32_t number = (random() % 2 ? 1 : -1) * std::int32_t(random() >> (8 + random() % 24));
                // By hand: whole steps in even states, half a step nearer to zero in odd ones.
                const std::int64_t nearer = state % 2 ? (number > 0 ? 8 : number < 0 ? -8 : 0) : 0;
                expected.push_back(writer.predict(c) + 16 * std::int64_t(number) - nearer);
                state = QuantiserTrellis::next(state, number);
                return number;
            });
            const std::uint64_t digest = encoder.digest();
            const Bytes bytes = encoder.finish();
            writer.store_frame(0, 1);
            MeteredDecoder decoder(bytes);
            reader.decode(decoder, 1);
            ASSERT_TRUE(decoder.complete()) << seed << " " << f;
            EXPECT_EQ(decoder.digest(), digest);
            for (int c = 0; c < channels; ++c) {
                EXPECT_EQ(reader.sample(c, 0, 1), expected[std::size_t(c)]) << seed << " " << f << " " << c;
                EXPECT_EQ(writer.sample(c, 0, 1), expected[std::size_t(c)]);
            }
        }
    }
}

}  // namespace
}  // namespace mien::coding
