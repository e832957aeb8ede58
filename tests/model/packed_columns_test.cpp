#include "model/packed_columns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mien::model {
namespace {

struct Case {
    Case(std::size_t rows, std::size_t k, unsigned seed) : start(rows), weights(k), columns(k, std::vector<std::int32_t>(rows)) {
        std::mt19937 random(seed);
        std::normal_distribution<float> normal;
        for (float& s : start) s = 100 * normal(random);
        for (float& w : weights) w = normal(random);
        for (auto& column : columns)
            for (auto& v : column) v = std::int32_t(random() % 65536) - 32768;
        for (std::size_t j = 0; j < k; ++j) scales.push_back(1e-4 * double(j + 1));
    }
    std::vector<double> truth() const {
        std::vector<double> x(start.begin(), start.end());
        for (std::size_t j = 0; j < columns.size(); ++j)
            for (std::size_t i = 0; i < x.size(); ++i) x[i] += double(weights[j]) * scales[j] * columns[j][i];
        return x;
    }
    // How far a sum of floats in any order may be off: a rounding of 2^-24 for every addition and factor, of all that is added.
    double rounding(std::size_t row) const {
        double size = std::abs(double(start[row]));
        for (std::size_t j = 0; j < columns.size(); ++j) size += std::abs(double(weights[j]) * scales[j] * columns[j][row]);
        return double(columns.size() + 3) * size / (1 << 24);
    }
    std::vector<float> start, weights;
    std::vector<std::vector<std::int32_t>> columns;
    std::vector<double> scales;
};

TEST(PackedColumns, AddUpAsTheirNumbersDoHoweverManyThereAre) {
    for (const std::size_t rows : {1u, 31u, 32u, 33u, 96u, 1000u})
        for (const std::size_t k : {1u, 3u, 64u, 65u, 130u}) {
            const Case c(rows, k, unsigned(rows * 1000 + k));
            const PackedColumns packed = PackedColumns::pack(c.columns, c.scales);
            ASSERT_EQ(packed.rows(), rows);
            ASSERT_EQ(packed.columns(), k);
            const std::vector<double> truth = c.truth();
            std::vector<float> fast(rows, std::nanf("")), plain(fast), in_place = c.start;
            packed.sum(c.start, c.weights, fast);
            packed.sum_plain(c.start, c.weights, plain);
            packed.sum(in_place, c.weights, in_place);
            EXPECT_EQ(in_place, fast);
            std::vector<float> portable(rows);
            packed.sum_portable(c.start, c.weights, portable);
            EXPECT_EQ(portable, fast);
            for (std::size_t i = 0; i < rows; ++i) {
                ASSERT_NEAR(fast[i], truth[i], c.rounding(i)) << rows << ' ' << k << ' ' << i;
                ASSERT_NEAR(plain[i], truth[i], c.rounding(i)) << rows << ' ' << k << ' ' << i;
            }
        }
}

/// Columns as a basis has them: large numbers first, and there in some places only.
TEST(PackedColumns, TakeAByteWhereThatIsEnough) {
    for (const std::size_t k : {7u, 16u, 300u}) {
        Case c(5000, k, unsigned(k));
        std::mt19937 random(2);
        for (std::size_t j = 0; j < k; ++j)
            for (std::size_t i = 0; i < 5000; ++i) c.columns[j][i] = std::int32_t(random() % 255) - 127 + (j < 3 && i / 1000 == j ? 1200 : 0);
        const PackedColumns packed = PackedColumns::pack(c.columns, c.scales);
        EXPECT_LT(packed.bytes(), 5000 * (k + 3) * 11 / 10);
        std::vector<float> fast(5000), portable(5000), plain(5000);
        packed.sum(c.start, c.weights, fast);
        packed.sum_portable(c.start, c.weights, portable);
        packed.sum_plain(c.start, c.weights, plain);
        EXPECT_EQ(portable, fast);
        const std::vector<double> truth = c.truth();
        double largest = 0;   // factor
        for (std::size_t j = 0; j < k; ++j) largest = std::max(largest, std::abs(double(c.weights[j]) * c.scales[j]));
        for (std::size_t i = 0; i < 5000; ++i) {
            ASSERT_NEAR(plain[i], truth[i], c.rounding(i)) << k << ' ' << i;
            ASSERT_NEAR(fast[i], truth[i], c.rounding(i) + (k < 300 ? largest / 32 : 0)) << k << ' ' << i;
        }
    }
}

TEST(PackedColumns, ThatDoNotMoveLeaveTheStartAsItIs) {
    Case c(70, 4, 8);
    std::vector<float> out(70);
    for (const float weight : {0.0f, 1e-44f}) {
        std::fill(c.weights.begin(), c.weights.end(), weight);
        PackedColumns::pack(c.columns, c.scales).sum(c.start, c.weights, out);
        EXPECT_EQ(out, c.start);
    }
}

TEST(PackedColumns, GiveNoNumberForWeightsThatAreNone) {
    const Case c(70, 3, 8);
    const PackedColumns packed = PackedColumns::pack(c.columns, c.scales);
    for (const float weight : {std::nanf(""), HUGE_VALF, -HUGE_VALF, 3e38f}) {
        std::vector<float> weights = c.weights, out(70);
        weights[1] = weight;
        packed.sum(c.start, weights, out);
        for (const float x : out) EXPECT_FALSE(std::isfinite(x)) << weight;
        packed.sum_portable(c.start, weights, out);
        for (const float x : out) EXPECT_FALSE(std::isfinite(x)) << weight;
    }
}

TEST(PackedColumns, AreEmptyWhereANumberNeedsMoreThan16Bits) {
    for (const auto& [value, fits] : {std::pair{32767, true}, {32768, false}, {-32768, true}, {-32769, false}}) {
        Case c(40, 2, 3);
        c.columns[1][39] = value;
        EXPECT_EQ(!PackedColumns::pack(c.columns, c.scales).empty(), fits) << value;
    }
    EXPECT_TRUE(PackedColumns::pack({}, {}).empty());
}

}  // namespace
}  // namespace mien::model
