#include <gtest/gtest.h>

#include <limits>

#include "analysis/evaluation.hpp"
#include "analysis/frame_predictors.hpp"
#include "analysis/texture_triangulation.hpp"
#include "tests/analysis/sheets.hpp"

namespace mien::analysis {
namespace {

constexpr int kSize = 32;

/// A model over the clip's markers with known coefficients: some mm of displacement, some hundredths of albedo.
struct Known {
    model::DetailModel model;
    std::shared_ptr<const model::MarkerDriver> driver;
};
Known known_model(const Clip& clip) {
    Known known;
    known.model.neutral = *clip.neutral;
    known.model.sites = clip.marker_sites;
    known.model.marker_triangles = triangulate_over_texture(*clip.neutral, clip.marker_sites);
    known.driver = std::make_shared<model::MarkerDriver>(*clip.neutral, clip.marker_sites, std::vector<std::uint32_t>{}, known.model.marker_triangles);
    DeformationMoments moments(known.driver->mesh());
    for (std::int64_t f = 0; f < clip.markers->frames; ++f) {
        Points markers = clip.markers->frame(f);
        model::fill_missing_markers(known.driver->mesh(), markers);
        moments.add(known.driver->meter().measure(markers));
    }
    known.model.axes = deformation_axes(moments);
    const TexelMap texels = make_texel_map(*clip.neutral, kSize, kSize);
    known.model.medium_domain = known.model.fine_domain = model::make_domain_map(*clip.neutral, texels, clip.marker_sites, known.driver->mesh(), 30);
    const std::size_t n = known.model.medium_domain.size();
    known.model.medium = known.model.albedo = model::PolynomialMap(3, model::PolynomialOrder::biquadratic, n);
    for (std::size_t i = 0; i < known.model.medium.planes.size(); ++i) {
        known.model.medium.planes[i] = 1.5f * std::sin(0.37f * float(i % 1013) + 0.2f);
        known.model.albedo.planes[i] = 0.04f * std::cos(0.21f * float(i % 977));
    }
    return known;
}

/// The largest difference of two maps' values over all frames of a clip, beside the largest value.
double relative_difference(const Clip& clip, const Known& known, const TrainedModel& trained, const model::PolynomialMap& a, const model::PolynomialMap& b) {
    double most = 0, scale = 0;
    std::vector<float> x(std::size_t(a.channels) * a.texels), y = x;
    EXPECT_EQ(a.texels, b.texels);
    for (std::int64_t f = 0; f < clip.markers->frames; ++f) {
        model::evaluate_plain(a, known.model.medium_domain, known.driver->drive(clip.markers->frame(f), known.model.axes).parameters, x.data());
        model::evaluate_plain(b, trained.model.medium_domain, trained.driver->drive(clip.markers->frame(f), trained.model.axes).parameters, y.data());
        for (std::size_t i = 0; i < x.size(); ++i) {
            most = std::max(most, double(std::abs(x[i] - y[i])));
            scale = std::max(scale, double(std::abs(x[i])));
        }
    }
    return most / scale;
}

TEST(Training, RecoversAKnownPolynomialDisplacementMapWithoutRidge) {
    Clip clip = sheet_clip(60);
    const Known known = known_model(clip);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    TrainingOptions options;
    options.axes.choice = AxisChoice::principal;   // as known_model() has them
    options.ridge = Ridge{};
    const auto trained = train(clip, options);
    ASSERT_TRUE(trained.ok()) << trained.error().message;
    ASSERT_EQ(trained->model.medium_domain.size(), known.model.medium_domain.size());
    EXPECT_LT(relative_difference(clip, known, *trained, known.model.medium, trained->model.medium), 1e-5);
    EXPECT_LT(relative_difference(clip, known, *trained, known.model.albedo, trained->model.albedo), 1e-5);
    double coefficients = 0;
    for (std::size_t i = 0; i < known.model.medium.planes.size(); ++i)
        coefficients = std::max(coefficients, double(std::abs(known.model.medium.planes[i] - trained->model.medium.planes[i])));
    EXPECT_LT(coefficients, 1e-3) << "where d1 and d2 vary enough, the coefficients themselves come back";
}

TEST(Training, TellingAxesFindWhatALayerFollows) {
    // All markers travel together by some mm, and the sheet stretches a little by itself; the layers follow its strains.
    Clip clip = sheet_clip(60);
    for (std::int64_t f = 1; f < 60; ++f) {
        const auto wave = [&](float frequency) { return std::sin(frequency * float(f)); };
        for (std::size_t m = 0; m < clip.marker_sites.size(); ++m) {
            const Vec3 p = clip.marker_sites[m].position(clip.neutral->positions);
            const Vec3 stretch(0.02f * p.x() * wave(1.9f), 0.02f * p.y() * wave(2.6f), 0);
            clip.markers->frame(f).row(Eigen::Index(m)) = (p + 3 * Vec3(wave(0.5f), wave(0.8f), wave(1.3f)) + stretch).transpose();
        }
    }
    Known known = known_model(clip);
    known.model.axes.q.setZero();
    known.model.axes.r.setZero();
    known.model.axes.q.col(3).setConstant(1.6f);   // about unit RMS
    known.model.axes.r.col(4).setConstant(1.6f);
    for (int c = 0; c < 3; ++c)   // both strains alike, and mostly linear, as skin is
        for (int t = 0; t < 6; ++t)
            for (std::size_t i = 0; i < known.model.medium.texels; ++i) {
                const float wave = (t < 3 ? 1.0f : 0.2f) * std::sin((0.31f + 0.17f * float(t)) * float(i % 211) + float(c));
                known.model.medium.plane(c, t)[i] = 1.5f * wave;
                known.model.albedo.plane(c, t)[i] = 0.04f * wave;
            }
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    const auto difference = [&](AxisChoice choice) {
        TrainingOptions options;
        options.ridge = Ridge{};
        options.axes.choice = choice;
        const auto trained = train(clip, options);
        EXPECT_TRUE(trained.ok());
        return relative_difference(clip, known, *trained, known.model.medium, trained->model.medium);
    };
    const double principal = difference(AxisChoice::principal), telling = difference(AxisChoice::telling);
    EXPECT_GT(principal, 0.3) << "they see the travel, which tells nothing";
    EXPECT_LT(telling, 0.2 * principal);
}

TEST(Training, MissingMarkersAreFilledInAndUnseenTexelsLeftOut) {
    Clip clip = sheet_clip(60);
    for (std::int64_t f = 1; f < 60; ++f) clip.markers->frame(f).row((7 * f) % 36).setConstant(std::numeric_limits<float>::quiet_NaN());
    const Known known = known_model(clip);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver, 4);
    TrainingOptions options;
    options.axes.choice = AxisChoice::principal;
    options.ridge = Ridge{};
    const auto trained = train(clip, options);
    ASSERT_TRUE(trained.ok()) << trained.error().message;
    const model::DomainMap& domain = trained->model.medium_domain;
    EXPECT_LT(domain.size(), known.model.medium_domain.size());
    for (const std::uint32_t place : domain.place) EXPECT_GE(place, 4u * kSize);
    const auto evaluated = [&] {
        TrainingOptions all = options;
        all.rivals = true;
        return evaluate_clip(*train(clip, all), clip);
    }();
    ASSERT_TRUE(evaluated.ok());
    for (const LayerErrors& way : evaluated->medium) {
        if (way.name == "biquadratic") {
            EXPECT_LT(way.errors.maximum(), 1e-3);
        }
        if (way.name == "linear") {
            EXPECT_GT(way.errors.mean(), 0.3);
        }
        if (way.name == "base") {
            EXPECT_GT(way.errors.mean(), 1);
        }
    }
}

TEST(Training, FewFramesStayFinite) {
    Clip clip = sheet_clip(7);
    const Known known = known_model(clip);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    for (const bool chosen : {false, true}) {
        TrainingOptions options;
        if (!chosen) options.ridge = Ridge{};
        const auto trained = train(clip, options);
        ASSERT_TRUE(trained.ok()) << trained.error().message;
        for (const float c : trained->model.medium.planes) ASSERT_TRUE(std::isfinite(c));
    }
    clip = sheet_clip(3);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    EXPECT_FALSE(train(clip, {}).ok()) << "no texel is seen often enough";
}

TEST(Training, OnTheMeshOfItsDecodersTheMapsMendWhatTheGridMoves) {
    Clip clip = sheet_clip(40);
    Known known = known_model(clip);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    Mesh coarse = *clip.neutral;
    coarse.positions = (2 * coarse.positions.array()).round().matrix() / 2;
    TrainingOptions options;
    options.axes.choice = AxisChoice::principal;
    options.ridge = Ridge{};
    options.neutral = coarse;
    const auto trained = train(clip, options);
    ASSERT_TRUE(trained.ok()) << trained.error().message;
    const Points rest = markers_at_rest(clip, trained->driver->mesh().neutral);
    const auto where = domain_texels(trained->model.medium_domain, make_texel_map(coarse, kSize, kSize));
    const std::size_t n = where.size();
    std::vector<float> left(3 * n), told(3 * n);
    double squares = 0;
    for (std::int64_t f = 0; f < 40; ++f) {
        const model::DrivenFrame driven = trained->driver->drive(head_space_markers(clip, f, rest, trained->driver->mesh().neutral), trained->model.axes);
        const Scan scan = *clip.scans->read(f, {true, false, false});
        medium_target(scan.medium, coarse, trained->model.medium_domain, where, driven.base, left.data());
        model::evaluate_plain(trained->model.medium, trained->model.medium_domain, driven.parameters, told.data());
        for (std::size_t i = 0; i < 3 * n; ++i) squares += double((left[i] - told[i]) * (left[i] - told[i]));
    }
    const double grid = double((coarse.positions - clip.neutral->positions).squaredNorm()) / double(coarse.positions.rows());
    EXPECT_GT(std::sqrt(grid), 0.1) << "mm that vertices are moved";
    EXPECT_LT(std::sqrt(squares / (40.0 * double(n))), 0.2 * std::sqrt(grid));
}

TEST(BatchPredictors, AreThoseOfItsFramesOneByOne) {
    Clip clip = sheet_clip(21);
    const Known known = known_model(clip);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    const auto trained = train(clip, {});
    ASSERT_TRUE(trained.ok());
    std::vector<std::unique_ptr<FramePredictors>> own;
    std::vector<const FramePredictors*> frames;
    for (std::int64_t f = 0; f < clip.markers->frames; ++f) {
        own.push_back(std::make_unique<FramePredictors>(*trained, clip.markers->frame(f)));
        frames.push_back(own.back().get());
    }
    const model::DomainMap& domain = trained->model.fine_domain;
    for (const auto& [kind, terms] : std::vector<std::pair<Predictors, int>>{{Predictors::polynomial, 3}, {Predictors::polynomial, 6}, {Predictors::polynomial, 10},
                                                                             {Predictors::deformation, 6}, {Predictors::global, 6}, {Predictors::neutral, 1}}) {
        const BatchPredictors batch(*trained, frames, kind, terms);
        ASSERT_EQ(batch.stride(), 32);
        std::vector<double> x(std::size_t(terms * batch.stride()), -1.0);
        double most = 0;
        for (std::size_t r = 0; r < domain.runs.size(); r += 5) {
            const std::uint32_t texel = domain.runs[r].begin;
            batch.at(domain, domain.runs[r].triangle, texel, x.data());
            for (std::size_t f = 0; f < frames.size(); ++f) {
                double one[model::kMaxTerms];
                frames[f]->at(kind, domain, domain.runs[r].triangle, texel, one);
                for (int k = 0; k < terms; ++k) {
                    const double here = x[std::size_t(k * batch.stride()) + f];
                    EXPECT_NEAR(here, one[k], 1e-6 * std::max(1.0, std::abs(one[k]))) << int(kind) << ' ' << k;
                    if (k > 0) most = std::max(most, std::abs(here));
                }
            }
            for (const double v : x) EXPECT_TRUE(std::isfinite(v));
        }
        EXPECT_TRUE(most > 0.5 || terms == 1) << "frames that move";
    }
}

TEST(Training, DeformationGoesNoFartherThanTheTrainingShowed) {
    Clip clip = sheet_clip(30);
    const Known known = known_model(clip);
    clip.scans = std::make_shared<ModelScans>(clip, known.model, known.driver);
    TrainingOptions options;
    options.ridge = Ridge{};
    const auto bounded = train(clip, options);
    options.bounded = false;
    const auto free = train(clip, options);
    ASSERT_TRUE(bounded.ok() && free.ok());
    EXPECT_EQ(free->model.axes.extents.size(), 0);
    EXPECT_EQ(bounded->model.medium.planes, free->model.medium.planes) << "training itself is as it was";
    const Points rest = bounded->driver->mesh().neutral, far = rest + 20 * (clip.markers->frame(7) - rest);
    const auto largest = [&](const TrainedModel& trained, const Points& markers) {
        std::vector<float> values(3 * trained.model.medium.texels);
        model::evaluate_plain(trained.model.medium, trained.model.medium_domain, trained.driver->drive(markers, trained.model.axes).parameters, values.data());
        float most = 0;
        for (const float v : values) most = std::max(most, std::abs(v));
        return most;
    };
    float shown = 0;
    for (std::int64_t f = 0; f < clip.markers->frames; ++f) shown = std::max(shown, largest(*bounded, clip.markers->frame(f)));
    EXPECT_LT(largest(*bounded, far), 3 * shown);
    EXPECT_GT(largest(*free, far), 30 * shown);
}

TEST(Training, SaysWhatIsMissing) {
    Clip clip = sheet_clip(8);
    auto result = train(clip, {});
    ASSERT_FALSE(result.ok());
    EXPECT_NE(result.error().message.find("scans"), std::string::npos);
    clip.marker_sites.clear();
    EXPECT_NE(train(clip, {}).error().message.find("marker_sites"), std::string::npos);
}

TEST(ErrorSummary, TellsMeanMaximumAndPercentiles) {
    ErrorSummary a, b;
    for (int i = 1; i <= 1000; ++i) (i % 2 ? a : b).add(i * 0.001);
    a.merge(b);
    EXPECT_NEAR(a.mean(), 0.5005, 1e-9);
    EXPECT_DOUBLE_EQ(a.maximum(), 1);
    EXPECT_NEAR(a.percentile(0.99), 0.99, 0.02);
    EXPECT_NEAR(a.percentile(0.5), 0.5, 0.01);
}

}  // namespace
}  // namespace mien::analysis
