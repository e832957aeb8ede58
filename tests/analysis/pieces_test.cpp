#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "analysis/frame_values.hpp"
#include "analysis/high_pass.hpp"
#include "analysis/layer_fit.hpp"
#include "analysis/texture_triangulation.hpp"
#include "tests/analysis/sheets.hpp"

namespace mien::analysis {
namespace {

std::vector<double> gather(const NormalEquations& equations, const std::vector<double>& truth, int samples) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    std::vector<double> sums(equations.size());
    for (int i = 0; i < samples; ++i) {
        double x[model::kMaxTerms], y = 0;
        const double d1 = normal(random), d2 = 0.4 * d1 + normal(random);
        model::polynomial_terms(d1, d2, x);
        for (std::size_t k = 0; k < truth.size(); ++k) y += truth[k] * x[k];
        equations.add(sums, x, &y);
    }
    return sums;
}

TEST(NormalEquations, GivesBackAPolynomialAndItsError) {
    const NormalEquations equations(6, 1);
    const std::vector<double> truth = {0.3, -1, 2, 0.5, -0.7, 0.11};
    const auto sums = gather(equations, truth, 40);
    double out[6];
    for (const bool orthogonal : {true, false}) {
        equations.solve(sums, 6, polynomial_degrees(), {0, 0, 0, orthogonal}, out);
        for (int k = 0; k < 6; ++k) EXPECT_NEAR(out[k], truth[std::size_t(k)], 1e-9);
        EXPECT_NEAR(equations.squared_error(sums, 0, 6, out), 0, 1e-8);
    }
}

TEST(NormalEquations, AStrongRidgeOnQuadraticTermsLeavesTheLinearFit) {
    const NormalEquations equations(6, 1);
    const auto sums = gather(equations, {0.3, -1, 2, 0.5, -0.7, 0.11}, 40);
    double linear[3], held[6], plain[6];
    equations.solve(sums, 3, polynomial_degrees(), {}, linear);
    equations.solve(sums, 6, polynomial_degrees(), {0, 1e9, 0, true}, held);
    equations.solve(sums, 6, polynomial_degrees(), {1e9, 1e9, 0, false}, plain);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(held[k], linear[k], 1e-6);
    EXPECT_NEAR(plain[1], 0, 1e-6) << "the paper's ridge holds all alike";
}

TEST(NormalEquations, WhatSamplesDoNotTellApartIsZero) {
    const NormalEquations equations(6, 1);
    std::vector<double> sums(equations.size());
    for (int i = 0; i < 9; ++i) {
        double x[model::kMaxTerms];
        const double d = i * 0.2, y = 1 + 3 * d;
        model::polynomial_terms(d, -2 * d, x);
        equations.add(sums, x, &y);
    }
    double out[6];
    equations.solve(sums, 6, polynomial_degrees(), {}, out);
    EXPECT_NEAR(out[0], 1, 1e-6);
    EXPECT_NEAR(out[1], 3, 1e-6);
    EXPECT_EQ(out[2], 0);
    EXPECT_EQ(out[4], 0);
    EXPECT_EQ(out[5], 0);
}

TEST(NormalEquations, ManyTogetherAreManyOneByOne) {
    constexpr int n = 3 * NormalEquations::kTogether, predictors = 6, values = 3;
    const NormalEquations equations(predictors, values);
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    std::vector<double> x(predictors * n), y(values * n), weights(n), together(equations.size(), 0.5), alone = together;
    for (double& v : x) v = normal(random);
    for (double& v : y) v = normal(random);
    for (double& w : weights) w = std::abs(normal(random));
    weights[3] = weights[15] = 0;
    equations.add_together(together, n, x.data(), y.data(), weights.data());
    for (int f = 0; f < n; ++f) {
        double one[predictors], own[values];
        for (int k = 0; k < predictors; ++k) one[k] = x[std::size_t(k * n + f)];
        for (int v = 0; v < values; ++v) own[v] = y[std::size_t(v * n + f)];
        equations.add(alone, one, own, weights[std::size_t(f)]);
    }
    for (std::size_t k = 0; k < together.size(); ++k) EXPECT_NEAR(together[k], alone[k], 1e-12) << k;
}

TEST(NormalEquations, SolvesEveryValueAsIfItWereTheOnlyOne) {
    const NormalEquations three(6, 3), one(6, 1);
    std::mt19937 random(9);
    std::normal_distribution<double> normal;
    std::vector<double> all(three.size());
    std::vector<std::vector<double>> own(3, std::vector<double>(one.size()));
    for (int i = 0; i < 25; ++i) {
        double x[model::kMaxTerms];
        model::polynomial_terms(normal(random), normal(random), x);
        const double y[] = {normal(random), normal(random) + x[3], x[1] - x[4] + 0.1 * normal(random)};
        three.add(all, x, y);
        for (std::size_t v = 0; v < 3; ++v) one.add(own[v], x, y + v);
    }
    for (const bool orthogonal : {true, false})
        for (const int terms : {3, 6}) {
            const Ridge ridge{0.01, 0.1, 0, orthogonal};
            double together[18], alone[6];
            three.solve(all, terms, polynomial_degrees(), ridge, together);
            for (int v = 0; v < 3; ++v) {
                one.solve(own[std::size_t(v)], terms, polynomial_degrees(), ridge, alone);
                for (int k = 0; k < terms; ++k) EXPECT_NEAR(together[v * terms + k], alone[k], 1e-12) << v << ' ' << k;
            }
        }
}

TEST(NormalEquations, AWeightCountsAsSoManySamples) {
    const NormalEquations equations(3, 2);
    std::vector<double> weighted(equations.size()), repeated(equations.size());
    for (int i = 0; i < 5; ++i) {
        const double x[] = {1, 0.3 * i, 1 - 0.1 * i * i}, y[] = {2.0 - i, 0.5 * i};
        equations.add(weighted, x, y, 3);
        for (int again = 0; again < 3; ++again) equations.add(repeated, x, y);
    }
    for (std::size_t i = 0; i < weighted.size(); ++i) EXPECT_NEAR(weighted[i], repeated[i], 1e-12);
}

/// For frames of a batch: the constant and what `of` says of a frame.
template <typename Of>
LayerFit::Drive line(int frames, const Of& of) {
    return [frames, of](std::uint32_t, double* x) {
        const int n = NormalEquations::padded(std::size_t(frames));
        for (int f = 0; f < n; ++f) x[f] = 1, x[n + f] = of(f);
    };
}

/// One texel over 40 frames of a line in x, but every fourth frame has something on top that no line explains.
TEST(LayerFit, WeighedAnewItFollowsWhatMostFramesSay) {
    std::vector<float> values(40);
    std::vector<LayerFit::Frame> frames;
    for (int f = 0; f < 40; ++f) {
        values[std::size_t(f)] = 0.5f + 0.2f * float(f % 7) + (f % 4 == 0 ? 1.0f + 0.1f * float(f % 3) : 0.001f * float(f % 2));
        frames.push_back({values.data() + f, 0});
    }
    const std::vector<int> degrees = linear_degrees(1);
    const LayerFit::Drive drive = line(40, [](int f) { return f % 7; });
    LayerFit fit(2, 1, 1, 1);
    fit.add(frames, drive);
    const double typical = fit.typical_error(2, degrees, {});
    EXPECT_NEAR(typical, fit.left_out_error(2, degrees, {}), 1e-12) << "one texel is its own median; one fold is left in";
    std::vector<float> planes = fit.solve(2, degrees, {});
    EXPECT_GT(planes[0], 0.65f) << "least squares gives a share to all frames";
    for (int round = 0; round < 8; ++round) {
        fit.reweigh(planes, 2, 0.01);
        fit.add(frames, drive);
        planes = fit.solve(2, degrees, {});
    }
    EXPECT_NEAR(planes[0], 0.5, 0.01);
    EXPECT_NEAR(planes[1], 0.2, 0.01);
}

/// Two texels of noise about a line, one ten times the other's.
TEST(LayerFit, SaysWhatNoiseRaisesItsMeanErrorByAShare) {
    std::vector<float> values;
    std::vector<LayerFit::Frame> frames;
    for (int f = 0; f < 40; ++f)
        for (const float size : {0.1f, 1.0f}) values.push_back(0.3f * float(f % 5) + (f % 2 == 0 ? size : -size));
    for (int f = 0; f < 40; ++f) frames.push_back({values.data() + 2 * f, 0});
    const std::vector<int> degrees = linear_degrees(1);
    LayerFit fit(2, 1, 2, 1);
    fit.add(frames, line(40, [](int f) { return f % 5; }));
    const double noise = fit.noise_for(0.1, 2, degrees, {});
    EXPECT_NEAR(std::hypot(0.1, noise) + std::hypot(1, noise), 1.1 * (0.1 + 1), 2e-3) << "errors are the sizes, but for what the line takes of them";
    EXPECT_GT(fit.noise_for(0.2, 2, degrees, {}), 1.3 * noise);
    EXPECT_NEAR(fit.noise_for(0, 2, degrees, {}), 0, 1e-6);
    EXPECT_NEAR(fit.left_out_error(2, degrees, {}), 0.55, 0.002) << "the mean of distances, not of squares";
}

TEST(FrameValues, KeepsTheFirstFramesAsFarAsTheyFitAndDropsTexels) {
    FrameValues values(5, 2, 3, 2, 2 * 2 * 3 * sizeof(float) + 1);
    for (std::int64_t frame = 0; frame < 5; ++frame) {
        EXPECT_FALSE(values.kept(frame));
        float* place = values.write(frame, frame % 2);
        for (int i = 0; i < 6; ++i) place[i] = float(10 * frame + i);
        EXPECT_EQ(values.kept(frame), frame < 2);
        EXPECT_EQ(values.read(frame, frame % 2)[5], float(10 * frame + 5));
    }
    values.keep({0, 2});
    const float* second = values.read(1, 0);
    EXPECT_EQ(std::vector<float>(second, second + 4), (std::vector<float>{10, 12, 13, 15}));
    EXPECT_FALSE(values.kept(2));
    values.write(2, 0)[3] = 7;
    EXPECT_EQ(values.read(2, 0)[3], 7);
}

TEST(DeformationAxes, AlignedFramesRunAlikeHaveUnitPowerAndKeepTheirPlanes) {
    const Clip clip = sheet_clip(50);
    const auto triangles = triangulate_over_texture(*clip.neutral, clip.marker_sites);
    const model::DeformationMeter meter(model::make_marker_mesh(*clip.neutral, clip.marker_sites, triangles));
    DeformationMoments moments(meter.mesh());
    std::vector<model::Deformations> all;
    for (std::int64_t f = 0; f < 50; ++f) {
        all.push_back(meter.measure(clip.markers->frame(f)));
        moments.add(all.back());
    }
    const auto energy = axis_energy(moments);
    EXPECT_NEAR(energy[4], 1, 1e-9);
    EXPECT_GT(energy[1], energy[0]);
    const model::DomainAxes axes = deformation_axes(moments), paper = deformation_axes(moments, {.smoothing = AxisSmoothing::none});
    double alike = 0, pairs = 0;
    for (std::size_t i = 0; i < moments.markers(); ++i) {
        const auto row = Eigen::Index(i);
        double p1 = 0, p12 = 0;
        for (const auto& S : all) {
            const double d1 = S.row(row).dot(axes.q.row(row)), d2 = S.row(row).dot(axes.r.row(row));
            p1 += d1 * d1 / 50;
            p12 += d1 * d2 / 50;
        }
        EXPECT_NEAR(p1, 1, 0.05);
        EXPECT_NEAR(p12, 0, 0.05);
        // The same plane as the principal axes': R of 2 x 5 frames has the same row space.
        Eigen::Matrix<float, 3, model::kDeformationSize> three;
        three << axes.q.row(row).normalized(), paper.q.row(row).normalized(), paper.r.row(row).normalized();
        EXPECT_LT(Eigen::JacobiSVD<Eigen::MatrixXf>(three).singularValues()[2], 1e-2f);
        for (std::size_t k = 0; k < moments.beside(i).size(); ++k) {
            const std::uint32_t j = moments.beside(i)[k];
            double shared = 0;
            for (const auto& S : all) shared += double(S.row(row).dot(axes.q.row(row))) * S.row(j).dot(axes.q.row(j)) / 50;
            alike += shared;
            ++pairs;
        }
    }
    EXPECT_GT(alike / pairs, 0.8) << "mean correlation of neighbouring markers' d1";
}

TEST(DeformationAxes, TellingOnesLieInThePlaneOfTheSlopesAndAreWhite) {
    const Clip clip = sheet_clip(1);
    const auto triangles = triangulate_over_texture(*clip.neutral, clip.marker_sites);
    const model::DeformationMeter meter(model::make_marker_mesh(*clip.neutral, clip.marker_sites, triangles));
    DeformationMoments moments(meter.mesh());
    // Offsets move five times as far as strains, each by itself.
    const auto M = Eigen::Index(moments.markers());
    for (int f = 0; f < 400; ++f) {
        model::Deformations S(M, model::kDeformationSize);
        for (Eigen::Index m = 0; m < M; ++m)
            for (int k = 0; k < model::kDeformationSize; ++k) S(m, k) = (k < 3 ? 3.0f : 0.6f) * std::sin(float(1 + k) * 0.31f * float(f) + 0.1f * float(m));
        moments.add(S);
    }
    std::vector<Moment> slopes(moments.markers(), Moment::Zero());
    for (Moment& slope : slopes) slope(3, 3) = slope(4, 4) = 1;
    slopes[7].setZero();   // its neighbours tell
    const auto planes = [&](const model::DomainAxes& axes, Eigen::Index m) {
        Eigen::Matrix<double, model::kDeformationSize, 2> W;
        W << axes.q.row(m).transpose().cast<double>(), axes.r.row(m).transpose().cast<double>();
        return W;
    };
    const model::DomainAxes telling = deformation_axes(moments, {}, slopes), untold = deformation_axes(moments, {}, std::vector<Moment>(moments.markers(), Moment::Zero())),
                            principal = deformation_axes(moments, {.choice = AxisChoice::principal}, slopes), none = deformation_axes(moments);
    EXPECT_EQ(untold.q, none.q) << "nothing told: the principal axes";
    EXPECT_EQ(principal.q, none.q);
    for (Eigen::Index m = 0; m < M; ++m) {
        const auto W = planes(telling, m), P = planes(none, m);
        const Eigen::Matrix2d power = W.transpose() * moments.at(std::size_t(m)) * W;
        EXPECT_LT((power - Eigen::Matrix2d::Identity()).norm(), 0.05);
        // Parts of d1 and d2 in units of what they move.
        EXPECT_LT(3.0 * W.topRows<3>().norm(), 0.05 * 0.6 * W.bottomRows<2>().norm());
        EXPECT_LT(0.6 * P.bottomRows<2>().norm(), 0.05 * 3.0 * P.topRows<3>().norm());
    }
}

TEST(TextureTriangulation, CoversASheetAndIsCutAtASlit) {
    Clip clip = sheet_clip(1);
    EXPECT_EQ(triangulate_over_texture(*clip.neutral, clip.marker_sites).size(), 50u) << "6 x 6 markers";
    // Without the triangles of one row the skin has a slit, but for its ends.
    Mesh mesh = *clip.neutral;
    std::erase_if(mesh.triangles, [](const Triangle& t) {
        const std::uint32_t low = std::min({t[0], t[1], t[2]}) / 21, column = t[0] % 21;
        return low == 9 && column >= 1 && column < 20;
    });
    mesh.texcoord_triangles = mesh.triangles;
    const auto cut = triangulate_over_texture(mesh, clip.marker_sites);
    EXPECT_LT(cut.size(), 50u);
    for (const Triangle& t : cut) {
        int above = 0, middle = 0;
        for (const std::uint32_t m : t) {
            above += mesh.positions(clip.marker_sites[m].vertices[0], 1) > -1;
            middle += std::abs(mesh.positions(clip.marker_sites[m].vertices[0], 0)) < 6;
        }
        EXPECT_TRUE(middle < 3 || above == 0 || above == 3) << "across the slit's middle";
    }
}

TEST(HighPass, KeepsFineWavesAndDropsSlowOnesAndIgnoresHoles) {
    FloatMap map(96, 80, 1);
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 96; ++x) *map.at(x, y) = 5 + 0.02f * float(x) + std::sin(2 * std::numbers::pi_v<float> * float(x) / 6);
    for (int y = 30; y < 40; ++y)
        for (int x = 20; x < 50; ++x) *map.at(x, y) = std::nanf("");
    const FloatMap high = high_pass(map, 6);
    for (int y = 24; y < 56; ++y)
        for (int x = 24; x < 72; ++x) {
            if (y >= 30 && y < 40 && x >= 20 && x < 50) EXPECT_TRUE(std::isnan(*high.at(x, y)));
            else EXPECT_NEAR(*high.at(x, y), std::sin(2 * std::numbers::pi_v<float> * float(x) / 6), 0.15f) << x << ' ' << y;
        }
}

}  // namespace
}  // namespace mien::analysis
