#include "encoder/frame_decision.hpp"

#include <gtest/gtest.h>

#include <random>

namespace mien::encoder {
namespace {

constexpr int kComponents = 40;

coding::MotionBasis causal_basis() {
    coding::MotionBasis basis;
    basis.scheme = coding::MotionScheme::causal;
    basis.components.resize(kComponents);
    basis.predictors.assign(kComponents, {200, 20, -10});
    return basis;
}

// Codes frames of targets uniform in +-range; mean squared error in squared steps and bits per number.
struct Spent {
    double error = 0, bits = 0;
};
Spent code(double range, double lambda) {
    std::mt19937 random(7);
    const coding::MotionBasis basis = causal_basis();
    const coding::MotionShape shape{.points = kComponents, .coordinates = 1};
    coding::MotionFrames frames(basis, shape), reader(basis, shape);
    constexpr int kFrames = 100;
    Spent spent;
    for (int f = 0; f < kFrames; ++f) {
        std::array<double, kComponents> targets;
        for (double& t : targets) t = range * (double(random()) / 2147483648.0 - 1);
        frames.begin_object(1);
        FrameCosts costs(frames);
        const FramePath path = choose_path(costs, kComponents, lambda, [&](int c) { return targets[std::size_t(c)]; },
                                           [](int) { return std::optional<std::int32_t>(); });
        Metered coder;
        frames.code_frame(coder, [&](int c) { return path.numbers[std::size_t(c)]; });
        spent.bits += coder.take_bits();
        const Bytes bytes = coder.finish();
        coding::MeteredDecoder decoder(bytes);
        reader.decode(decoder, 1);
        EXPECT_TRUE(decoder.complete());
        double error = 0;
        for (int c = 0; c < kComponents; ++c) {
            const double decoded = double(reader.sample(c, 0, 1)) / coding::MotionBasis::kFraction;
            EXPECT_EQ(decoded, path.decoded[std::size_t(c)]) << f << " " << c;
            error += (decoded - targets[std::size_t(c)]) * (decoded - targets[std::size_t(c)]);
        }
        EXPECT_NEAR(error, path.squared_error, 1e-9);
        spent.error += error;
    }
    spent.error /= kFrames * kComponents;
    spent.bits /= kFrames * kComponents;
    return spent;
}

TEST(FramePath, LeavesLessThanOneQuantiserWouldAtItsBits) {
    // One quantiser leaves 1/12 and spends the log of how many of its steps the values fill.
    constexpr double kRange = 64;
    const Spent spent = code(kRange, 1e-6);
    EXPECT_LT(spent.error, 0.82 / 12);
    EXPECT_LT(spent.bits, std::log2(4 * kRange));   // targets less predictions reach twice as far
}

TEST(FramePath, TradesErrorForBits) {
    const Spent fine = code(3, 0.01), coarse = code(3, 0.3);
    EXPECT_LT(coarse.bits, 0.8 * fine.bits);
    EXPECT_GT(coarse.error, fine.error);
}

TEST(FramePath, KeepsNumbersThatAreSettled) {
    const coding::MotionBasis basis = causal_basis();
    const coding::MotionShape shape{.points = kComponents, .coordinates = 1};
    const coding::MotionFrames frames(basis, shape);
    FrameCosts costs(frames);
    const FramePath path = choose_path(costs, kComponents, 0.12, [](int c) { return 0.3 * c; }, [](int c) {
        return c % 3 == 0 ? std::optional<std::int32_t>(c) : std::nullopt;
    });
    for (int c = 0; c < kComponents; c += 3) EXPECT_EQ(path.numbers[std::size_t(c)], c);
}

}  // namespace
}  // namespace mien::encoder
