#include "render/edge_smoothing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/parallel.hpp"

namespace mien::render {
namespace {

constexpr int kWidth = 70, kHeight = 90;   // more rows than one task takes
using Pixels = std::vector<std::uint8_t>;

/// White right of a slanted line, black left of it; by the middles of pixels, or by how much of them is covered.
double coverage(double x, double y) { return x > 0.35 * y + 20 ? 1 : 0; }
Pixels drawn() {
    Pixels pixels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 4; ++c) pixels.push_back(c == 3 ? 255 : std::uint8_t(255 * coverage(x + 0.5, y + 0.5)));
    return pixels;
}
double covered(int x, int y) {
    double sum = 0;
    for (int i = 0; i < 16; ++i)
        for (int j = 0; j < 16; ++j) sum += coverage(x + (i + 0.5) / 16, y + (j + 0.5) / 16);
    return sum / 256;
}
double error(const Pixels& pixels) {
    double sum = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) sum += std::abs(pixels[std::size_t(4 * (y * kWidth + x))] / 255.0 - covered(x, y));
    return sum;
}

Pixels smoothed(const Pixels& pixels, const Eigen::AlignedBox2i& box) {
    Pixels out(pixels.size());
    smooth_edges(pixels.data(), kWidth, kHeight, box, out.data());
    return out;
}
const Eigen::AlignedBox2i kWhole(Eigen::Vector2i::Zero(), Eigen::Vector2i(kWidth, kHeight));

TEST(EdgeSmoothing, ASlantedEdgeComesNearerToWhatItCovers) {
    const Pixels pixels = drawn();
    const double before = error(pixels), after = error(smoothed(pixels, kWhole));
    EXPECT_GT(before, 15);
    EXPECT_LT(after, 0.8 * before);
}

TEST(EdgeSmoothing, WhatHasNoEdgeStaysAsItIs) {
    Pixels pixels;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)   // a slope that eight bits show in steps of one code
            for (int c = 0; c < 4; ++c) pixels.push_back(std::uint8_t(c == 3 ? 255 : 60 + (x + y) / 8));
    EXPECT_EQ(smoothed(pixels, kWhole), pixels);
}

TEST(EdgeSmoothing, NothingOutsideTheBoxChanges) {
    const Pixels pixels = drawn(), whole = smoothed(pixels, kWhole);
    const Eigen::AlignedBox2i box(Eigen::Vector2i(25, 10), Eigen::Vector2i(40, 60));
    const Pixels part = smoothed(pixels, box);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 4; ++c) {
                const bool inside = x >= 25 && x < 40 && y >= 10 && y < 60;
                const std::size_t at = std::size_t(4 * (y * kWidth + x) + c);
                ASSERT_EQ(part[at], inside ? whole[at] : pixels[at]) << x << ' ' << y;
            }
    EXPECT_EQ(smoothed(pixels, Eigen::AlignedBox2i()), pixels);
    EXPECT_EQ(smoothed(pixels, {Eigen::Vector2i(-5, -5), Eigen::Vector2i(kWidth + 5, kHeight + 5)}), whole);
}

TEST(EdgeSmoothing, ThreadsChangeNothing) {
    const Pixels pixels = drawn();
    set_thread_count(1);
    const Pixels one = smoothed(pixels, kWhole);
    set_thread_count(3);
    EXPECT_EQ(smoothed(pixels, kWhole), one);
    set_thread_count(0);
}

}  // namespace
}  // namespace mien::render
