#include <gtest/gtest.h>

#include <cmath>

#include "encoder/texture_regions.hpp"
#include "encoder/texture_scale.hpp"
#include "encoder/texture_shrink.hpp"
#include "encoder/texture_weight.hpp"
#include "tests/texture/clips.hpp"

namespace mien {
namespace {

/// A square of `side` mm, its texture the given rectangle of the atlas; corners anticlockwise as seen from where it faces.
void add_square(Mesh& mesh, const Vec3& low, const Vec3& across, const Vec3& up, Vec2 uv_low, Vec2 uv_high) {
    const auto v = mesh.vertex_count();
    const auto t = std::uint32_t(mesh.texcoords.size());
    mesh.positions.conservativeResize(v + 4, 3);
    const Vec3 corners[4] = {low, low + across, low + across + up, low + up};
    const Vec2 uvs[4] = {uv_low, {uv_high.x(), uv_low.y()}, uv_high, {uv_low.x(), uv_high.y()}};
    for (int i = 0; i < 4; ++i) {
        mesh.positions.row(v + i) = corners[i].transpose();
        mesh.texcoords.push_back(uvs[i]);
    }
    for (const Triangle& corner : {Triangle{0, 1, 2}, Triangle{0, 2, 3}}) {
        mesh.triangles.push_back({v + corner[0], v + corner[1], v + corner[2]});
        mesh.texcoord_triangles.push_back({t + corner[0], t + corner[1], t + corner[2]});
    }
}

const Vec3 kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

/// Mean over the usual cameras of the cosine between them and a direction, none below zero.
double mean_cosine(const Vec3& normal) {
    double sum = 0;
    for (const double pitch : {-20.0, 0.0, 20.0})
        for (const double yaw : {-45.0, -22.5, 0.0, 22.5, 45.0}) {
            const double y = yaw * M_PI / 180, p = pitch * M_PI / 180;
            sum += std::max(0.0f, Vec3(float(std::sin(y) * std::cos(p)), float(std::sin(p)), float(std::cos(y) * std::cos(p))).dot(normal));
        }
    return sum / 15;
}

TEST(TextureWeight, IsTheAreaThatTheUsualCamerasSee) {
    // Four quarters of the atlas: to the front; to the front, twice as wide; to the side; away. Far from each other.
    Mesh mesh;
    add_square(mesh, {0, 0, 0}, 20 * kX, 20 * kY, {0, 0}, {0.5f, 0.5f});
    add_square(mesh, {100, 0, 0}, 40 * kX, 20 * kY, {0.5f, 0}, {1, 0.5f});
    add_square(mesh, {300, 0, 0}, -20 * kZ, 20 * kY, {0, 0.5f}, {0.5f, 1});
    add_square(mesh, {500, 0, 0}, -20 * kX, 20 * kY, {0.5f, 0.5f}, {1, 1});
    const TexelMap map = make_texel_map(mesh, 32, 32);
    const std::vector<float> seen = encoder::seen_area(mesh, mesh.positions, map);
    const double texel = 20.0 * 20 / (16 * 16);
    const auto at = [&](int x, int y) { return seen[std::size_t(y) * 32 + x]; };
    EXPECT_NEAR(at(8, 24), texel * mean_cosine(kZ), 1e-3);
    EXPECT_NEAR(at(24, 24), 2 * texel * mean_cosine(kZ), 1e-3);
    EXPECT_NEAR(at(8, 8), texel * mean_cosine(kX), 1e-3);
    EXPECT_EQ(at(24, 8), 0);
}

TEST(TextureWeight, LeavesOutWhatSomethingElseHides) {
    Mesh mesh;
    add_square(mesh, {-50, -50, 0}, 100 * kX, 100 * kY, {0, 0}, {0.5f, 1});       // in front
    add_square(mesh, {-5, -5, -6}, 10 * kX, 10 * kY, {0.5f, 0}, {0.75f, 1});      // right behind it
    add_square(mesh, {-5, -5, 10}, 10 * kX, 10 * kY, {0.75f, 0}, {1, 1});         // before it
    const TexelMap map = make_texel_map(mesh, 32, 32);
    const auto sees = [&](const Mesh& shape) { return encoder::seen_area(shape, shape.positions, map); };
    std::vector<float> seen = sees(mesh);
    EXPECT_EQ(seen[16 * 32 + 20], 0);
    EXPECT_GT(seen[16 * 32 + 28], 0);
    // A cornea hides nothing and shows no texture of its own.
    mesh.parts = {{"skin", Surface::cornea, 0, 2}, {"behind", Surface::eye, 2, 2}, {"before", Surface::eye, 4, 2}};
    seen = sees(mesh);
    EXPECT_GT(seen[16 * 32 + 20], 0);
    EXPECT_EQ(seen[16 * 32 + 8], 0);
}

TEST(TextureWeight, CountsWhatOpensOnlyInThePerformanceAndHasMeanOne) {
    Clip clip;
    clip.neutral.emplace();
    Mesh& mesh = *clip.neutral;
    add_square(mesh, {-50, -50, 0}, 100 * kX, 100 * kY, {0, 0}, {0.5f, 1});
    add_square(mesh, {-5, -5, -6}, 10 * kX, 10 * kY, {0.5f, 0}, {0.9f, 1});
    const auto hidden = encoder::texture_weights(clip, 40, 40);
    EXPECT_EQ(hidden[20 * 40 + 30], 0);

    clip.vertices.emplace(12, mesh.positions.rows());
    for (std::int64_t f = 0; f < 12; ++f) {
        clip.vertices->frame(f) = mesh.positions;
        if (f >= 6) clip.vertices->frame(f).topRows(4).col(0).array() += 200;   // out of the way
    }
    const auto opened = encoder::texture_weights(clip, 40, 40);
    EXPECT_GT(opened[20 * 40 + 30], 0);
    double sum = 0, used = 0;
    for (int i = 0; i < 40 * 40; ++i) {
        sum += opened[std::size_t(i)];
        used += i % 40 < 36;
        if (i % 40 >= 36) {
            EXPECT_EQ(opened[std::size_t(i)], 0);
        }
    }
    EXPECT_NEAR(sum / used, 1, 1e-4);
}

TEST(TextureWeight, IsOneEverywhereWithoutAMesh) {
    for (const float weight : encoder::texture_weights(texture_test::painted_clip(20, 10, 2), 20, 10)) EXPECT_EQ(weight, 1);
}

TEST(TextureShrink, TakesSmallDetailFromWhatIsNotSeenAndNothingElse) {
    // The left half is seen, the right one hardly; both hold a wave of amplitude 2 and a step of 100.
    std::vector<float> weights(64 * 64);
    media::YuvImage picture(64, 64, media::Chroma::quarter);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            weights[std::size_t(y) * 64 + x] = x < 32 ? 2.0f : 1 / 16.0f;
            picture.planes[0][std::size_t(y) * 64 + x] = std::uint8_t(100 + (x % 2 ? 2 : -2) + (y % 8 < 4 ? 100 : 0));
        }
    for (int p : {1, 2}) std::fill(picture.planes[p].begin(), picture.planes[p].end(), std::uint8_t(90));
    const media::YuvImage before = picture;
    const encoder::TextureShrink shrink(weights, 64, 64);
    shrink.apply(picture, 0, nullptr);
    EXPECT_EQ(picture.planes[0], before.planes[0]);
    shrink.apply(picture, 6, nullptr);
    double wave = 0, step = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; x += 2) {
            const auto* row = picture.planes[0].data() + std::size_t(y) * 64;
            if (x < 32) {
                EXPECT_EQ(row[x], before.planes[0][std::size_t(y) * 64 + x]);
                EXPECT_EQ(row[x + 1], before.planes[0][std::size_t(y) * 64 + x + 1]);
            } else {
                wave += std::abs(row[x + 1] - row[x]) / (64.0 * 16);
                step += (y % 8 < 4 ? 1 : -1) * double(row[x]) / (32 * 16);
            }
        }
    EXPECT_LT(wave, 0.5);   // of 4
    EXPECT_NEAR(step, 100, 2);
    EXPECT_EQ(picture.planes[1], before.planes[1]);
}

TEST(TextureShrink, WhatIsNotSeenStandsStillUntilItHasChangedMuch) {
    std::vector<float> weights(32 * 16);
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = i % 32 < 16 ? 2.0f : 0.25f;   // excess 3: a step of 4 shrinks below 4 sqrt(3)
    const encoder::TextureShrink shrink(weights, 32, 16);
    const auto grey = [](int level) {
        media::YuvImage picture(32, 16, media::Chroma::quarter);
        for (auto& plane : picture.planes) std::fill(plane.begin(), plane.end(), std::uint8_t(level));
        return picture;
    };
    const media::YuvImage before = grey(100);
    media::YuvImage little = grey(100);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 32; ++x) little.planes[0][std::size_t(y) * 32 + x] = std::uint8_t(100 + (x + y) % 2);   // 0.5 even and 4 in the finest wave
    media::YuvImage still = little;
    shrink.apply(still, 4, &before);
    for (int x = 0; x < 32; ++x) EXPECT_EQ(still.planes[0][std::size_t(x)], x < 16 ? little.planes[0][std::size_t(x)] : 100) << x;
    media::YuvImage large = grey(110);
    shrink.apply(large, 4, &before);   // 80 and 80 (1 - 48 / 6400)
    EXPECT_EQ(large.planes[0][0], 110);
    EXPECT_NEAR(large.planes[0][31], 109.9, 0.51);
    EXPECT_EQ(large.planes[1][15], 110) << "chroma alike";
}

TEST(TextureScale, MeansWhatAPixelCovers) {
    Image picture(3, 2, 1);
    picture.pixels = {0, 30, 60, 90, 120, 151};
    EXPECT_EQ(encoder::scaled_down(picture, 3, 2).pixels, picture.pixels);
    // Columns of 1.5: (0 + 15) / 1.5 = 10, (15 + 60) / 1.5 = 50; (90 + 60) / 1.5 = 100, (60 + 151) / 1.5 = 140.67.
    EXPECT_EQ(encoder::scaled_down(picture, 2, 2).pixels, (std::vector<std::uint8_t>{10, 50, 100, 141}));
    EXPECT_EQ(encoder::scaled_down(picture, 1, 1).pixels, (std::vector<std::uint8_t>{75}));
}

TEST(TextureRegions, FollowTheLogarithmOfTheMeanWeightOfABlock) {
    // Blocks of 16: weight 1, 4, a quarter of 1 / 2 and the rest none, none; the last column and row are cut.
    std::vector<float> weights(40 * 20);
    const auto fill = [&](int x0, int x1, int y0, int y1, float weight) {
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) weights[std::size_t(y) * 40 + x] = weight;
    };
    fill(0, 16, 0, 16, 1);
    fill(16, 32, 0, 16, 4);
    fill(32, 40, 0, 16, 0.5f);
    fill(0, 8, 16, 20, 0.5f);
    const auto regions = encoder::texture_regions(weights, 40, 20);
    const auto is = [](const media::VideoRegion& region, int left, int top, int right, double offset) {
        EXPECT_EQ(region.left, left);
        EXPECT_EQ(region.top, top);
        EXPECT_EQ(region.right, right);
        EXPECT_EQ(region.bottom, top + 16);
        EXPECT_EQ(region.qp_offset, offset);
    };
    ASSERT_EQ(regions.size(), 5u);
    is(regions[0], 0, 0, 16, 0);
    is(regions[1], 16, 0, 32, -6);
    is(regions[2], 32, 0, 48, 3);
    is(regions[3], 0, 16, 16, 6);
    is(regions[4], 16, 16, 48, 12);
}

}  // namespace
}  // namespace mien
