#include "coding/vector_quantiser.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "coding/point_influence.hpp"
#include "coding/vector_coder.hpp"

namespace mien::coding {
namespace {

constexpr std::uint32_t kSide = 40;
constexpr std::array<std::uint8_t, PointOrder::kLevels> kSteps{32, 22, 14, 10, 7, 6, 6, 6};

std::vector<Triangle> grid() {
    std::vector<Triangle> triangles;
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
        for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
            const std::uint32_t a = y * kSide + x;
            triangles.push_back({a, a + 1, a + kSide});
            triangles.push_back({a + 1, a + kSide + 1, a + kSide});
        }
    return triangles;
}

std::vector<std::uint32_t> mirror() {
    std::vector<std::uint32_t> mirror(kSide * kSide);
    for (std::uint32_t v = 0; v < mirror.size(); ++v) mirror[v] = v / kSide * kSide + kSide - 1 - v % kSide;
    return mirror;
}

// A bump at either side, `sign` times as high at the second, seen in the mirror, and noise that nobody can predict.
std::vector<double> bumps(double sign, double noise) {
    std::mt19937 random(11);
    std::vector<double> field(kSide * kSide * 3);
    for (std::uint32_t y = 0; y < kSide; ++y)
        for (std::uint32_t x = 0; x < kSide; ++x)
            for (std::uint32_t c = 0; c < 3; ++c) {
                const auto bump = [&](double cx, double cy) { return 900 * std::exp(-(std::pow(x - cx, 2) + std::pow(y - cy, 2)) / 40); };
                const double flip = c == 0 ? -1 : 1;
                field[(y * kSide + x) * 3 + c] = bump(9.5 + c, 17) + sign * flip * bump(kSide - 1 - (9.5 + c), 17) +
                                                 noise * (double(random()) / 4294967296.0 - 0.5);
            }
    return field;
}

struct Coded {
    double bits, error;
};

Coded quantise(const std::vector<double>& field, const PointOrder& order, double lambda, int rounds) {
    const MotionShape shape{.points = kSide * kSide};
    VectorQuantiser quantiser(shape, order, kSteps);
    const auto vector = quantiser.quantise(field, lambda, rounds);
    Coded out{quantiser.bits(), 0};
    for (std::size_t i = 0; i < field.size(); ++i) out.error += (vector[i] - field[i]) * (vector[i] - field[i]);

    // The writer reproduces it, and the reader gets it from the bytes.
    RangeEncoder encoder;
    std::vector<std::int32_t> walk(field.size(), 0), back(field.size(), 0);
    VectorCoder(shape, order, kSteps).code(encoder, walk, [&](const VectorCoder::Value& v, const auto&, auto&) {
        EXPECT_EQ((vector[v.index] - v.prediction) % v.step, 0);
        return std::int32_t((vector[v.index] - v.prediction) / v.step);
    });
    const Bytes bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    VectorCoder(shape, order, kSteps).code(decoder, back, [](const VectorCoder::Value&, const auto&, auto&) { return 0; });
    EXPECT_TRUE(decoder.complete());
    EXPECT_EQ(walk, vector);
    EXPECT_EQ(back, vector);
    EXPECT_NEAR(8.0 * double(bytes.size()), out.bits, 24) << "what the quantiser weighs is what the coder writes";
    return out;
}

TEST(PointInfluence, SurprisesTimesSharesMakeTheVector) {
    const PointOrder order = mesh_order(kSide * kSide, grid());
    const PointInfluence influence(order);
    const auto field = bumps(1, 20);
    std::vector<double> made(kSide * kSide, 0);
    for (std::size_t at = 0; at < order.order.size(); ++at) {
        double sum = 0, weight = 0;
        for (const auto& r : order.of(at)) sum += r.weight * field[r.point * 3 + 1], weight += r.weight;
        const double surprise = field[order.order[at] * 3 + 1] - (weight > 0 ? sum / weight : 0);
        double energy = 0;
        for (const auto& share : influence.of(at)) {
            made[share.point] += share.weight * surprise;
            energy += share.weight * share.weight;
        }
        EXPECT_NEAR(energy, influence.energy(at), 1e-3 * energy);
        EXPECT_EQ(influence.of(at).front().point, order.order[at]);
    }
    for (std::size_t p = 0; p < made.size(); ++p) EXPECT_NEAR(made[p], field[p * 3 + 1], 4) << "tails below 1/1024 of 900 are cut off";
}

TEST(PointInfluence, StaysSmallAlongAChainOfParents) {
    std::vector<std::uint32_t> parents(20000);
    for (std::uint32_t i = 1; i < parents.size(); ++i) parents[i] = i - 1;
    const PointInfluence influence(parent_order(parents));
    EXPECT_LE(influence.of(0).size(), 300u);
    EXPECT_GE(influence.energy(0), 200.0f);
}

TEST(VectorQuantiser, TakesTheNearestWhenBitsDoNotMatter) {
    const auto field = bumps(0.3, 200);
    const PointOrder order = mesh_order(kSide * kSide, grid(), mirror());
    const Coded coded = quantise(field, order, 0, 1);
    EXPECT_LT(coded.error / double(field.size()), 32.0 * 32 / 12 * 1.05) << "uniform within a step of the finest level at most";
}

TEST(VectorQuantiser, RoundsSaveErrorAndBitsTogether) {
    const PointOrder order = mesh_order(kSide * kSide, grid());
    const double lambda = 0.12 * 32 * 32;
    for (const double noise : {0.0, 40.0}) {
        const auto field = bumps(1, noise);
        const Coded once = quantise(field, order, lambda, 1), thrice = quantise(field, order, lambda, 3);
        EXPECT_LT(thrice.error + lambda * thrice.bits, once.error + lambda * once.bits) << noise;
    }
}

TEST(VectorQuantiser, WhatMirrorsCostsLittleTheSecondTimeEitherWayRound) {
    const double lambda = 0.12 * 32 * 32;
    const PointOrder plain = mesh_order(kSide * kSide, grid()), mirrored = mesh_order(kSide * kSide, grid(), mirror());
    for (const double sign : {1.0, -1.0}) {
        const auto field = bumps(sign, 0);
        const Coded one = quantise(field, plain, lambda, 3), two = quantise(field, mirrored, lambda, 3);
        EXPECT_LT(two.error + lambda * two.bits, 0.85 * (one.error + lambda * one.bits)) << sign;
    }
    const auto lopsided = bumps(0, 0);
    const Coded one = quantise(lopsided, plain, lambda, 3), two = quantise(lopsided, mirrored, lambda, 3);
    EXPECT_LT(two.error + lambda * two.bits, 1.1 * (one.error + lambda * one.bits)) << "a face that moves at one side pays little for it";
}

}  // namespace
}  // namespace mien::coding
