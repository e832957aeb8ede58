#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "model/detail_model.hpp"
#include "model/polynomial_map_avx2.hpp"

namespace mien::model {
namespace {

/// Four markers, two triangles, runs of odd lengths.
struct Small {
    MarkerMesh mesh;
    DomainAxes axes;
    DomainMap domain;
    Deformations S{4, kDeformationSize};
    Small() {
        std::mt19937 random(3);
        std::normal_distribution<float> normal;
        const auto fill = [&](auto&& matrix) {
            for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = normal(random);
        };
        mesh.neutral.resize(4, 3);
        mesh.neutral << 0, 0, 0, 10, 0, 0, 10, 10, 0, 0, 10, 0;
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.u = mesh.v = Points::Zero(4, 3);
        mesh.u.col(0).setOnes();
        mesh.v.col(1).setOnes();
        axes = {Deformations(4, kDeformationSize), Deformations(4, kDeformationSize)};
        fill(axes.q), fill(axes.r), fill(S);
        domain.width = 10;
        domain.height = 5;
        domain.runs = {{0, 0, 21}, {1, 21, 37}};
        std::uniform_real_distribution<float> uniform(0, 0.5f);
        for (std::uint32_t i = 0; i < 37; ++i) {
            domain.place.push_back(i);
            domain.b1.push_back(uniform(random));
            domain.b2.push_back(uniform(random));
        }
    }
};

TEST(DomainParameters, AreTheProductOfInterpolatedDeformationAndAxes) {
    const Small small;
    const DomainParameters parameters = domain_parameters(small.mesh, small.axes, small.S);
    for (const DomainMap::Run& run : small.domain.runs)
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            const float b1 = small.domain.b1[i], b2 = small.domain.b2[i];
            const Triangle& c = small.mesh.triangles[run.triangle];
            const auto mix = [&](const Deformations& rows) {
                return Eigen::Matrix<float, 1, kDeformationSize>((1 - b1 - b2) * rows.row(c[0]) + b1 * rows.row(c[1]) + b2 * rows.row(c[2]));
            };
            EXPECT_NEAR(parameters.d1[run.triangle].at(b1, b2), mix(small.S).dot(mix(small.axes.q)), 1e-5f);
            EXPECT_NEAR(parameters.d2[run.triangle].at(b1, b2), mix(small.S).dot(mix(small.axes.r)), 1e-5f);
        }
}

TEST(DomainParameters, AMarkerThatStraysIsDrawnBackToItsExtent) {
    Small small;
    small.domain.b1.assign(37, 0), small.domain.b2.assign(37, 0);   // all texels at the first corner, marker 0
    const auto at_marker_0 = [&] {
        const DomainParameters parameters = domain_parameters(small.mesh, small.axes, small.S);
        return Eigen::Vector2f(parameters.d1[0].at(0, 0), parameters.d2[0].at(0, 0));
    };
    const Eigen::Vector2f d = at_marker_0();
    add_extents(small.axes.extents, small.axes, small.S);
    EXPECT_NEAR(small.axes.extents[0], d.norm(), 1e-5f);
    EXPECT_LE((at_marker_0() - d).norm(), 1e-6f) << "as far as it went";
    small.S *= 0.7f;
    EXPECT_LE((at_marker_0() - 0.7f * d).norm(), 1e-5f);
    small.S *= 50;
    EXPECT_LE((at_marker_0() - d).norm(), 1e-4f) << "no farther, in the same direction";
    small.S.row(1).setZero();
    EXPECT_LE((at_marker_0() - d).norm(), 1e-4f) << "each marker has its own";
    small.axes.extents.resize(0);
    EXPECT_LE((at_marker_0() - 35 * d).norm(), 1e-2f) << "without extents";
}

TEST(PolynomialMap, FastAndPlainEvaluationAgreeForEveryOrder) {
    if (!avx2_available()) GTEST_SKIP() << "no AVX2 here";
    const Small small;
    const DomainParameters parameters = domain_parameters(small.mesh, small.axes, small.S);
    std::mt19937 random(9);
    std::normal_distribution<float> normal;
    for (const auto order : {PolynomialOrder::constant, PolynomialOrder::linear, PolynomialOrder::biquadratic, PolynomialOrder::bicubic}) {
        PolynomialMap map(3, order, small.domain.size());
        for (float& c : map.planes) c = normal(random);
        std::vector<float> plain(3 * map.texels), fast(plain.size(), std::numeric_limits<float>::quiet_NaN());
        evaluate_plain(map, small.domain, parameters, plain.data());
        evaluate_avx2(map, small.domain, parameters, fast.data());
        for (std::size_t i = 0; i < plain.size(); ++i) EXPECT_NEAR(fast[i], plain[i], 1e-4f * (1 + std::abs(plain[i]))) << int(order) << ' ' << i;
    }
}

TEST(DeformationMeter, MeasuresOffsetsAndTheSpreadAlongTheTextureAxes) {
    MarkerMesh mesh = Small().mesh;
    const DeformationMeter meter(mesh);
    EXPECT_EQ(meter.neighbourhood(1).size(), 4u);
    EXPECT_LT(meter.measure(mesh.neutral).cwiseAbs().maxCoeff(), 1e-5f);
    Points stretched = mesh.neutral;
    stretched.col(0) *= 1.5f;
    stretched.col(1) *= 0.8f;
    const Deformations S = meter.measure(stretched);
    for (int m = 0; m < 4; ++m) {
        EXPECT_NEAR(S(m, 3), 2 * 2.5f, 1e-4f) << "sqrt(4) times half of the neutral standard deviation of 5";
        EXPECT_NEAR(S(m, 4), 2 * -1.0f, 1e-4f);
    }
    EXPECT_NEAR(S(1, 0), 5, 1e-5f);
    Points shifted = mesh.neutral.rowwise() + Eigen::RowVector3f(1, 2, 3);
    EXPECT_LT(meter.measure(shifted).rightCols<2>().cwiseAbs().maxCoeff(), 1e-5f) << "no strain";
}

TEST(MissingMarkers, TakeTheirNeighboursOffsets) {
    const MarkerMesh mesh = Small().mesh;
    Points markers = mesh.neutral.rowwise() + Eigen::RowVector3f(1, -2, 0.5f);
    const Points truth = markers;
    markers.row(1).setConstant(std::numeric_limits<float>::quiet_NaN());
    ASSERT_TRUE(fill_missing_markers(mesh, markers));
    EXPECT_LT((markers - truth).cwiseAbs().maxCoeff(), 1e-4f);
    markers.setConstant(std::numeric_limits<float>::quiet_NaN());
    EXPECT_FALSE(fill_missing_markers(mesh, markers));
}

TEST(DomainSampler, IsBilinearInsideAndKeepsToTheDomainAtItsEdge) {
    const Small small;
    const DomainSampler sampler(small.domain);
    std::vector<float> values(small.domain.size());
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = 3 * float(i % 10) - 2 * float(i / 10);
    const auto at = [&](float x, float y) { return sampler.at({(x + 0.5f) / 10, 1 - (y + 0.5f) / 5}); };
    EXPECT_NEAR(sampled(at(4.25f, 1.5f), values.data(), values.size(), 0), 3 * 4.25f - 2 * 1.5f, 1e-3f);
    EXPECT_NEAR(sampled(at(6, 3.5f), values.data(), values.size(), 0), 3 * 6 - 2 * 3, 1e-3f) << "row 4 is outside";
    EXPECT_EQ(at(8.9f, 4.4f).count, 0);
}

}  // namespace
}  // namespace mien::model
