#include "samples/skin.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "samples/procedural_actor.hpp"
#include "samples/skin_paint.hpp"

namespace mien::samples {
namespace {

constexpr int kSize = 192;

const Actor& actor() {
    static const std::unique_ptr<Actor> head = make_procedural_actor();
    return *head;
}

const Skin& skin() {
    static const Skin painted(actor(), kSize, 0);
    return painted;
}

Vec3 on_neutral(const TexelMap::Texel& texel) {
    const Triangle& t = actor().neutral().triangles[texel.triangle];
    const Points& p = actor().neutral().positions;
    return ((1 - texel.b1 - texel.b2) * p.row(t[0]) + texel.b1 * p.row(t[1]) + texel.b2 * p.row(t[2]))
        .transpose();
}

Surface surface_of(const TexelMap::Texel& texel) {
    static const std::vector<Surface> surfaces = actor().neutral().triangle_surfaces();
    return surfaces[texel.triangle];
}

float luminance(const float* linear) {
    return 0.2126f * linear[0] + 0.7152f * linear[1] + 0.0722f * linear[2];
}

// Mean of texels whose neutral place satisfies `where`, sRGB codes.
template <class Where>
Vec3 mean_colour(const Image& image, Where where) {
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const TexelMap::Texel& texel = skin().texel_map().at(x, y);
            if (texel.triangle == TexelMap::kNone || !where(texel)) continue;
            const std::uint8_t* pixel = image.at(x, y);
            sum += Vec3(pixel[0], pixel[1], pixel[2]);
            ++count;
        }
    EXPECT_GT(count, 4);
    return sum / float(std::max(1, count));
}

TEST(Skin, IsTheSameForTheSameSeedAndAnotherForAnother) {
    const Skin again(actor(), kSize, 0), other(actor(), kSize, 7);
    const Image first = skin().texture({}, actor().neutral().positions);
    EXPECT_EQ(first.pixels, again.texture({}, actor().neutral().positions).pixels);
    EXPECT_NE(first.pixels, other.texture({}, actor().neutral().positions).pixels);
}

TEST(Skin, ThreadsMayAskForFramesAtOnce) {
    const Image truth = skin().texture({}, actor().neutral().positions);
    std::vector<Image> images(3);
    std::vector<std::thread> threads;
    for (Image& image : images)
        threads.emplace_back([&] { image = skin().texture({}, actor().neutral().positions); });
    for (std::thread& thread : threads) thread.join();
    for (const Image& image : images) EXPECT_EQ(image.pixels, truth.pixels);
}

TEST(Skin, MaskIsWhatTheChartsCoverAndEveryCoveredTexelIsPainted) {
    const Image mask = skin().mask();
    const FloatMap albedo = skin().albedo();
    const TexelMap map = make_texel_map(actor().neutral(), kSize, kSize);
    int covered = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            ASSERT_EQ(*mask.at(x, y), map.used(x, y) ? 255 : 0) << x << ' ' << y;
            covered += map.used(x, y);
            for (int k = 0; k < 3; ++k) {
                if (map.used(x, y)) {
                    ASSERT_GT(albedo.at(x, y)[k], 0) << x << ' ' << y;
                    ASSERT_LT(albedo.at(x, y)[k], 1) << x << ' ' << y;
                } else {
                    ASSERT_EQ(albedo.at(x, y)[k], 0) << x << ' ' << y;
                }
            }
        }
    EXPECT_GT(covered, kSize * kSize / 2);
}

TEST(Skin, TexelsNearAChartRepeatItsNearestTexels) {
    const Image image = skin().texture({}, actor().neutral().positions);
    const TexelMap& map = skin().texel_map();
    int checked = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            if (map.used(x, y)) continue;
            // The ring of the nearest charted texels, and whether one of them has this colour.
            for (int reach = 1; reach <= 8; ++reach) {
                bool charted = false, equal = false;
                for (int j = std::max(0, y - reach); j <= std::min(kSize - 1, y + reach); ++j)
                    for (int i = std::max(0, x - reach); i <= std::min(kSize - 1, x + reach); ++i)
                        if (map.used(i, j)) {
                            charted = true;
                            equal |= std::equal(image.at(i, j), image.at(i, j) + 3, image.at(x, y));
                        }
                if (!charted) continue;
                ++checked;
                ASSERT_TRUE(equal) << x << ' ' << y;
                break;
            }
        }
    EXPECT_GT(checked, 500);
}

TEST(Skin, ReddensWhereSqueezedAndBlanchesWhereStretched) {
    const Vec3 cheek = actor().landmarks().cheek[1];
    const auto pulled =
        [&](float strength) {  // the cheek's surface toward or away from its middle, within 30 mm
            Points p = actor().neutral().positions;
            for (Eigen::Index v = 0; v < p.rows(); ++v) {
                const Vec3 off = p.row(v).transpose() - cheek;
                const float part = std::max(0.0f, 1 - off.norm() / 30);
                p.row(v) += (strength * part * off).transpose();
            }
            return p;
        };
    const auto in_patch = [&](const TexelMap::Texel& t) {
        return surface_of(t) == Surface::skin && (on_neutral(t) - cheek).norm() < 10;
    };
    const auto far_off = [&](const TexelMap::Texel& t) {
        return surface_of(t) == Surface::skin && (on_neutral(t) - actor().landmarks().cheek[0]).norm() < 10;
    };
    const auto redness = [](const Vec3& c) { return c.x() / c.y(); };
    const Image still = skin().texture({}, actor().neutral().positions);
    const Image squeezed = skin().texture({}, pulled(-0.3f)), stretched = skin().texture({}, pulled(0.3f));
    EXPECT_GT(redness(mean_colour(squeezed, in_patch)), 1.04f * redness(mean_colour(still, in_patch)));
    EXPECT_LT(redness(mean_colour(stretched, in_patch)), 0.99f * redness(mean_colour(still, in_patch)));
    EXPECT_GT(mean_colour(stretched, in_patch).y(), mean_colour(still, in_patch).y());
    EXPECT_NEAR(redness(mean_colour(squeezed, far_off)), redness(mean_colour(still, far_off)), 0.01f);
}

TEST(Skin, AnOpeningMouthLetsLightInToTheTeeth) {
    Instant open;
    open.weights[std::size_t(arkit_index("JawOpen"))] = 1;
    const auto teeth = [&](const TexelMap::Texel& t) {
        return surface_of(t) == Surface::teeth &&
               on_neutral(t).z() > line_point(actor().landmarks().upper_lip_line, 0.5f).z() - 9;   // incisors and canines
    };
    const Vec3 closed_mouth = mean_colour(skin().texture({}, actor().deform({})), teeth);
    const Vec3 open_mouth = mean_colour(skin().texture(open, actor().deform(open)), teeth);
    EXPECT_LT(closed_mouth.y(), 140);
    EXPECT_GT(open_mouth.y(), closed_mouth.y() + 35);
}

TEST(Skin, AnOpenMouthIsDarkRedAndNoHole) {
    Instant open;
    open.weights[std::size_t(arkit_index("JawOpen"))] = 0.7f;
    const Landmarks& marks = actor().landmarks();
    const Vec3 seam = line_point(marks.lower_lip_line, 0.5f);
    const auto tongue = [&](const TexelMap::Texel& t) {   // what of it one sees from the front
        const Vec3 p = on_neutral(t);
        return surface_of(t) == Surface::mouth && std::abs(p.x()) < 12 && p.y() < seam.y() && p.z() < seam.z() - 14 && p.z() > seam.z() - 28;
    };
    const Vec3 colour = mean_colour(skin().texture(open, actor().deform(open)), tongue);
    EXPECT_GT(colour.x(), 120);
    EXPECT_LT(colour.x(), 190);   // paler than that it would be skin
    EXPECT_GT(colour.x(), 1.5f * colour.y());
    EXPECT_GT(colour.x(), 1.5f * colour.z());
}

TEST(Skin, BrowsLieOnTheBrowLine) {
    const FloatMap albedo = skin().albedo();
    const Landmarks& marks = actor().landmarks();
    const Places places(marks);
    for (int side = 0; side < 2; ++side) {
        double on = 0, above = 0, below = 0;
        int on_count = 0, above_count = 0, below_count = 0;
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const TexelMap::Texel& texel = skin().texel_map().at(x, y);
                if (texel.triangle == TexelMap::kNone || surface_of(texel) != Surface::skin) continue;
                const Vec3 p = on_neutral(texel);
                if (Places::side_of(p) != side) continue;
                float along = 0;
                const float off = line_distance(marks.brow[side], p, &along);
                if (along < 0.15f || along > 0.8f || p.z() < 0.5f * marks.glabella.z()) continue;
                const float light = luminance(albedo.at(x, y));
                const bool over = p.y() > line_point(marks.brow[side], along).y();
                if (off < 2.0f) on += light, ++on_count;
                if (off > 9 && off < 14)
                    (over ? above : below) += light, ++(over ? above_count : below_count);
            }
        ASSERT_GT(on_count, 5);
        ASSERT_GT(above_count, 5);
        ASSERT_GT(below_count, 5);
        EXPECT_LT(on / on_count, 0.6 * above / above_count);
        EXPECT_LT(on / on_count, 0.6 * below / below_count);
    }
}

TEST(Skin, FrecklesKeepToNoseAndCheeksAndOffLipsAndEyes) {
    Complexion clear, freckled;
    clear.freckles = 0;
    freckled.freckles = 3;
    const FloatMap without = Skin(actor(), kSize, 3, clear).albedo(),
                   with = Skin(actor(), kSize, 3, freckled).albedo();
    const Landmarks& marks = actor().landmarks();
    const Places places(marks);
    int all = 0, at_home = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const TexelMap::Texel& texel = skin().texel_map().at(x, y);
            if (texel.triangle == TexelMap::kNone ||
                luminance(with.at(x, y)) > 0.97f * luminance(without.at(x, y)))
                continue;
            const Vec3 p = on_neutral(texel);
            ASSERT_EQ(surface_of(texel), Surface::skin);
            EXPECT_LT(places.into_lips(p), 0);
            EXPECT_LT(places.into_eye(p, Places::side_of(p)), 0.5f);
            ++all;
            at_home += std::min({places.from(p, marks.cheek[0]), places.from(p, marks.cheek[1]),
                                 places.from(p, marks.nose_tip), places.from(p, marks.glabella)}) < 42;
        }
    EXPECT_GT(all, 60);
    EXPECT_GT(at_home, 0.7 * all);
}

TEST(Skin, EverySeedIsAPlausiblePerson) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Complexion c = Complexion::of_seed(seed);
        const Vec3 tone = skin_albedo(c.melanin, c.haemoglobin);
        EXPECT_GT(tone.x(), tone.y()) << seed;
        EXPECT_GT(tone.y(), tone.z()) << seed;
        // Measured human skin reflects between about 4 % and 65 % of green light.
        EXPECT_GT(tone.y(), 0.04f) << seed;
        EXPECT_LT(tone.y(), 0.65f) << seed;
        EXPECT_LT(luminance(c.hair.data()), luminance(tone.data())) << seed;
        EXPECT_GE(c.freckles, 0) << seed;
    }
}

TEST(Skin, FaceTexelsStayWithinTheGamutOfSkin) {
    const FloatMap albedo = skin().albedo();
    const Places places(actor().landmarks());
    int count = 0, strange = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const TexelMap::Texel& texel = skin().texel_map().at(x, y);
            if (texel.triangle == TexelMap::kNone || surface_of(texel) != Surface::skin) continue;
            const Vec3 p = on_neutral(texel);
            if (places.into_scalp(p) > -5 || places.into_lips(p) > -3) continue;
            const int side = Places::side_of(p);
            if (places.from_upper_lid(p, side) < 4 || line_distance(actor().landmarks().brow[side], p) < 9)
                continue;
            if (places.from(p, actor().landmarks().nostril[side]) < 18) continue;
            const float* a = albedo.at(x, y);
            ++count;
            strange += !(a[0] > a[1] && a[1] > a[2] && a[0] < 0.85f && a[2] > 0.05f);
        }
    EXPECT_GT(count, 2000);
    EXPECT_LT(strange, count / 200);
}

TEST(Skin, HairThinsOutTowardsTheForehead) {
    // Bands of 4 mm from the forehead up: each is darker than the one below, and no step is the whole way.
    const FloatMap albedo = skin().albedo();
    const Places places(actor().landmarks());
    std::array<double, 6> light{};
    std::array<int, 6> count{};
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const TexelMap::Texel& texel = skin().texel_map().at(x, y);
            if (texel.triangle == TexelMap::kNone) continue;
            const Surface surface = surface_of(texel);
            const Vec3 p = on_neutral(texel);
            if ((surface != Surface::skin && surface != Surface::hair) || std::abs(p.x()) > 35 || p.z() < actor().landmarks().eye_centre[0].z() - 20) continue;
            const int band = int(std::floor((places.into_scalp(p) + 6) / 4));
            if (band < 0 || band > 5) continue;
            light[std::size_t(band)] += luminance(albedo.at(x, y));
            ++count[std::size_t(band)];
        }
    for (std::size_t i = 0; i < light.size(); ++i) {
        ASSERT_GT(count[i], 10) << i;
        light[i] /= count[i];
    }
    for (std::size_t i = 1; i < light.size(); ++i) {
        EXPECT_LT(light[i], light[i - 1] + 0.01) << i;
        EXPECT_GT(light[i], light[i - 1] - 0.6 * (light.front() - light.back())) << i;
    }
    EXPECT_LT(light.back(), 0.35 * light.front());
}

TEST(Skin, PupilsAreDarkIrisesColouredAndScleraPale) {
    const FloatMap albedo = skin().albedo();
    const Landmarks& marks = actor().landmarks();
    const Places places(marks);
    double pupil = 0, iris = 0, sclera = 0;
    int pupils = 0, irises = 0, scleras = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const TexelMap::Texel& texel = skin().texel_map().at(x, y);
            if (texel.triangle == TexelMap::kNone || surface_of(texel) != Surface::eye) continue;
            const Vec3 q = on_neutral(texel) - marks.eye_centre[Places::side_of(on_neutral(texel))];
            if (q.z() < 0) continue;
            const float r = q.head<2>().norm() / places.iris_radius(), light = luminance(albedo.at(x, y));
            if (r < 0.2f) pupil += light, ++pupils;
            if (r > 0.5f && r < 0.75f) iris += light, ++irises;
            if (r > 1.3f && r < 1.5f) sclera += light, ++scleras;
        }
    ASSERT_GT(pupils, 0);
    ASSERT_GT(irises, 0);
    ASSERT_GT(scleras, 0);
    EXPECT_LT(pupil / pupils, 0.01);
    EXPECT_GT(iris / irises, 0.03);
    EXPECT_LT(iris / irises, 0.35);
    EXPECT_GT(sclera / scleras, 0.45);
    EXPECT_LT(sclera / scleras, 0.75);  // never pure white
}

}  // namespace
}  // namespace mien::samples
