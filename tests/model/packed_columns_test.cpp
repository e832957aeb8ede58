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
            for (std::size_t i = 0; i < rows; ++i) {
                ASSERT_NEAR(fast[i], truth[i], c.rounding(i)) << rows << ' ' << k << ' ' << i;
                ASSERT_NEAR(plain[i], truth[i], c.rounding(i)) << rows << ' ' << k << ' ' << i;
            }
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
