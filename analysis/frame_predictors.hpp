#pragma once

#include <vector>

#include "analysis/training.hpp"

namespace mien::analysis {

inline constexpr int kGlobalPredictors = 5;   ///< of Predictors::global, after the constant
/// Predictors of a texel, the constant included.
int predictor_count(Predictors kind);

/// What explains the texels of one frame.
class FramePredictors {
public:
    /// markers: M x 3 in head space; missing ones (NaN) are filled in.
    FramePredictors(const TrainedModel& trained, PointsRef markers);

    const model::DomainParameters& parameters() const { return parameters_; }
    const model::Deformations& S() const { return S_; }
    const double* global() const { return global_; }
    /// The base shape, V x 3 mm: worked out at every call.
    Points base() const { return trained_.driver->base(markers_); }
    /// Writes predictor_count(kind) numbers; `triangle` is that of the texel's run.
    void at(Predictors kind, const model::DomainMap& domain, std::uint32_t triangle, std::uint32_t texel, double* out) const;

private:
    const TrainedModel& trained_;
    Points markers_;
    model::Deformations S_;
    model::DomainParameters parameters_;
    double global_[kGlobalPredictors];
};

/// The first `terms` predictors of a texel for many frames at once: FramePredictors::at of each.
class BatchPredictors {
public:
    BatchPredictors(const TrainedModel& trained, const std::vector<const FramePredictors*>& frames, Predictors kind, int terms);

    /// x [terms][stride()]; behind the last frame are zeros, but for the constant.
    void at(const model::DomainMap& domain, std::uint32_t triangle, std::uint32_t texel, double* x) const;
    int stride() const { return stride_; }

private:
    const TrainedModel& trained_;
    Predictors kind_;
    int terms_, stride_;
    std::vector<float> rows_;     // polynomial: [triangle][d1, d2][c][frame]; deformation: [marker][component][frame]
    std::vector<double> global_;  // [component][frame]
};

}  // namespace mien::analysis
