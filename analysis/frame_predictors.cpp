#include "analysis/frame_predictors.hpp"

#include <algorithm>
#include <cassert>

#include "analysis/polynomial_fit.hpp"
#include "core/wide.hpp"

namespace mien::analysis {
namespace {

constexpr int kQuadratic = 6;   // coefficients of DomainParameters::Quadratic

/// Terms of d1 and d2 for n frames: as DomainParameters::Quadratic::at and polynomial_terms. rows [d1, d2][c][n], x [terms][n].
MIEN_LOOP polynomial_loop(const float* rows, float b1, float b2, int n, int terms, double* x) {
    for (int d = 0; d < 2; ++d) {
        const float* c = rows + d * kQuadratic * n;
        for (int f = 0; f < n; ++f) x[(1 + d) * n + f] = double(c[f] + b1 * (c[n + f] + c[3 * n + f] * b1 + c[4 * n + f] * b2) + b2 * (c[2 * n + f] + c[5 * n + f] * b2));
    }
    const double *d1 = x + n, *d2 = x + 2 * n;
    for (int f = 0; f < n; ++f) x[f] = 1;
    if (terms > 3)
        for (int f = 0; f < n; ++f) x[3 * n + f] = d1[f] * d1[f], x[4 * n + f] = d1[f] * d2[f], x[5 * n + f] = d2[f] * d2[f];
    if (terms > 6)
        for (int f = 0; f < n; ++f)
            x[6 * n + f] = d1[f] * d1[f] * d1[f], x[7 * n + f] = d1[f] * d1[f] * d2[f], x[8 * n + f] = d1[f] * d2[f] * d2[f], x[9 * n + f] = d2[f] * d2[f] * d2[f];
}
MIEN_WIDE(polynomial, (const float* rows, float b1, float b2, int n, int terms, double* x), (rows, b1, b2, n, terms, x))

}  // namespace

int predictor_count(Predictors kind) {
    switch (kind) {
        case Predictors::polynomial: return model::kMaxTerms;
        case Predictors::deformation: return 1 + model::kDeformationSize;
        case Predictors::global: return 1 + kGlobalPredictors;
        case Predictors::neutral: return 1;
    }
    return 0;
}

FramePredictors::FramePredictors(const TrainedModel& trained, PointsRef markers) : trained_(trained), markers_(markers) {
    const model::MarkerMesh& mesh = trained.driver->mesh();
    if (!model::fill_missing_markers(mesh, markers_)) markers_ = mesh.neutral;
    S_ = trained.driver->meter().measure(markers_);
    parameters_ = model::domain_parameters(mesh, trained.model.axes, S_);
    const Points offset = markers_ - mesh.neutral;
    const Eigen::VectorXd flat = Eigen::Map<const Eigen::VectorXf>(offset.data(), offset.size()).cast<double>();
    Eigen::Map<Eigen::Matrix<double, kGlobalPredictors, 1>> scores(global_);
    scores = trained.global_components.transpose() * flat;
}

void FramePredictors::at(Predictors kind, const model::DomainMap& domain, std::uint32_t triangle, std::uint32_t texel, double* out) const {
    const float b1 = domain.b1[texel], b2 = domain.b2[texel];
    out[0] = 1;
    if (kind == Predictors::polynomial) {
        model::polynomial_terms(double(parameters_.d1[triangle].at(b1, b2)), double(parameters_.d2[triangle].at(b1, b2)), out);
    } else if (kind == Predictors::deformation) {
        const Triangle& c = trained_.model.marker_triangles[triangle];
        for (int k = 0; k < model::kDeformationSize; ++k)
            out[1 + k] = double((1 - b1 - b2) * S_(c[0], k) + b1 * S_(c[1], k) + b2 * S_(c[2], k)) / trained_.deformation_scale[k];
    } else if (kind == Predictors::global) {
        std::copy_n(global_, kGlobalPredictors, out + 1);
    }
}

BatchPredictors::BatchPredictors(const TrainedModel& trained, const std::vector<const FramePredictors*>& frames, Predictors kind, int terms)
    : trained_(trained), kind_(kind), terms_(terms), stride_(NormalEquations::padded(frames.size())) {
    assert(terms >= 1 && terms <= predictor_count(kind) && (kind != Predictors::polynomial || terms >= 3));
    const auto n = std::size_t(stride_);
    if (kind == Predictors::polynomial) {
        const std::size_t triangles = trained.model.marker_triangles.size();
        rows_.resize(triangles * 2 * kQuadratic * n);
        for (std::size_t f = 0; f < frames.size(); ++f)
            for (std::size_t t = 0; t < triangles; ++t)
                for (std::size_t c = 0; c < kQuadratic; ++c) {
                    rows_[((2 * t) * kQuadratic + c) * n + f] = frames[f]->parameters().d1[t].c[c];
                    rows_[((2 * t + 1) * kQuadratic + c) * n + f] = frames[f]->parameters().d2[t].c[c];
                }
    } else if (kind == Predictors::deformation) {
        const auto markers = std::size_t(trained.driver->mesh().neutral.rows());
        rows_.resize(markers * model::kDeformationSize * n);
        for (std::size_t f = 0; f < frames.size(); ++f)
            for (std::size_t m = 0; m < markers; ++m)
                for (int k = 0; k < model::kDeformationSize; ++k) rows_[(m * model::kDeformationSize + std::size_t(k)) * n + f] = frames[f]->S()(Eigen::Index(m), k);
    } else if (kind == Predictors::global) {
        global_.resize(kGlobalPredictors * n);
        for (std::size_t f = 0; f < frames.size(); ++f)
            for (std::size_t k = 0; k < kGlobalPredictors; ++k) global_[k * n + f] = frames[f]->global()[k];
    }
}

void BatchPredictors::at(const model::DomainMap& domain, std::uint32_t triangle, std::uint32_t texel, double* x) const {
    const auto n = std::size_t(stride_);
    const float b1 = domain.b1[texel], b2 = domain.b2[texel];
    if (kind_ == Predictors::polynomial) {
        polynomial(rows_.data() + std::size_t(triangle) * 2 * kQuadratic * n, b1, b2, stride_, terms_, x);
        return;
    }
    std::fill_n(x, n, 1.0);
    if (kind_ == Predictors::deformation) {
        const Triangle& corners = trained_.model.marker_triangles[triangle];
        for (int k = 0; k + 1 < terms_; ++k) {
            const auto row = [&](int c) { return rows_.data() + (std::size_t(corners[std::size_t(c)]) * model::kDeformationSize + std::size_t(k)) * n; };
            const float *s0 = row(0), *s1 = row(1), *s2 = row(2);
            const double scale = trained_.deformation_scale[k];
            double* to = x + std::size_t(1 + k) * n;
            for (std::size_t f = 0; f < n; ++f) to[f] = double((1 - b1 - b2) * s0[f] + b1 * s1[f] + b2 * s2[f]) / scale;
        }
    } else if (kind_ == Predictors::global) {
        std::copy_n(global_.data(), std::size_t(terms_ - 1) * n, x + n);
    }
}

}  // namespace mien::analysis
