#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/deformation_axes.hpp"
#include "analysis/polynomial_fit.hpp"
#include "core/clip.hpp"
#include "core/progress.hpp"
#include "model/detail_model.hpp"
#include "model/term_basis.hpp"

namespace mien::analysis {

/// What the values of a texel are explained by.
enum class Predictors {
    polynomial,   ///< the terms of d1, d2
    deformation,  ///< rival of equal storage: 1 and the interpolated 5-D vector S
    global,       ///< rival of equal storage: 1 and the first five principal components of all markers' offsets
    neutral,      ///< rival: the mean over frames at rest
};

/// What the fine layer is measured over.
enum class FineOver {
    scan,   ///< the medium surface as scanned: the layer learns the skin's relief alone
    model,  ///< the model's own medium surface: it also takes over, from the training frames, what the medium layer could not say
};

struct TrainingOptions {
    AxisOptions axes;
    /// Strengths; unset: chosen by leaving out one part of a take after another (the paper's way: axes.smoothing = paper,
    /// axes.choice = principal and a small Ridge with orthogonal = false).
    std::optional<Ridge> ridge;
    model::PolynomialOrder order = model::PolynomialOrder::biquadratic;
    /// What to train on instead of the clip's neutral mesh: the same on the grid that the model's decoders have it on, so that the maps mend
    /// what the grid moves.
    std::optional<Mesh> neutral;
    std::vector<std::uint32_t> fixed;  ///< vertices that follow the head pose alone: skull, neck ring
    /// Rounds of weighing samples anew after least squares (0: the paper's way), of the medium layer and of fine layer and albedo. What
    /// happens seldom and bends past a threshold, a wrinkle, then no longer leaves its shadow on a face at rest.
    int medium_rounds = 1, rounds = 4;
    bool bounded = true;          ///< (d1, d2) never longer than in training (the paper's way: false)
    bool rivals = false;          ///< also fit all orders and rivals, for a report
    double reach_mm = 30;         ///< texels farther from every marker, along the skin, are left out
    FineOver fine_over = FineOver::scan;
    double high_pass_mm = 4;      ///< sigma of what the medium layer is left to carry
    double stored_share = 0.1;    ///< of the fine layer's mean error of the training frames, that storing may add: TrainedModel::fine_stored
    Progress progress;
};

/// A fitted way to explain one layer: coefficients [channel][term][texel] of some predictors.
struct FittedMap {
    Predictors predictors = Predictors::polynomial;
    int terms = 0, channels = 0;
    Ridge ridge;
    std::vector<float> planes;
};

struct TrainedModel {
    model::DetailModel model;
    std::shared_ptr<const model::MarkerDriver> driver;
    std::array<double, model::kDeformationSize> axis_energy{};  ///< Table 1 of the paper, cumulative
    Ridge medium_ridge, fine_ridge, albedo_ridge;
    double fine_stored = 0;       ///< RMS that storing may add to the fine layer, mm, so that its mean error grows by options.stored_share
    model::TermMoments moments;   ///< of d1, d2 at every marker over the training frames: what coding the maps goes by
    std::int64_t frames = 0;
    double high_pass_sigma = 0;   ///< texels of the fine map
    FineOver fine_over = FineOver::scan;

    // With options.rivals, in this order: polynomial linear, biquadratic, bicubic; deformation; global; neutral.
    std::vector<FittedMap> medium, fine, albedo;
    Eigen::MatrixXd global_components;  ///< 3M x 5, scaled to scores of unit RMS
    Eigen::Matrix<double, model::kDeformationSize, 1> deformation_scale;  ///< RMS of the components of S
};

/// Fits a face's detail from a clip with neutral, marker_sites, markers and scans (Ma et al. 2008, section 4). Scans are read
/// twice, a few at a time; of more frames than some hundred again in every round. Errors: what is missing, by name; those of the scans.
Result<TrainedModel> train(const Clip& clip, const TrainingOptions& options);

/// Where a clip's markers are at rest: on its neutral mesh where it says where they sit, else where the model's, `neutral_markers`, are.
Points markers_at_rest(const Clip& clip, PointsRef neutral_markers);
/// Markers of a frame in the model's head space: the clip's pose removed, or one fitted to the markers at rest where the clip has none;
/// then as far from the model's neutral markers as they were from rest.
Points head_space_markers(const Clip& clip, std::int64_t frame, PointsRef rest, PointsRef neutral_markers);

/// Where every texel of a domain is on the mesh.
std::vector<TexelMap::Texel> domain_texels(const model::DomainMap& domain, const TexelMap& texels);

/// mm that a texel of a map spans, on average over a domain.
double texel_span(const Mesh& neutral, const model::DomainMap& domain, const std::vector<TexelMap::Texel>& where);

/// What the medium layer is to explain: scan minus base shape, [3][texels] mm; NaN: not seen.
void medium_target(const FloatMap& scan, const Mesh& neutral, const model::DomainMap& domain, const std::vector<TexelMap::Texel>& where,
                   PointsRef base, float* out);
/// What the fine layer is to explain: how far the full scan lies over the medium surface along the normal of the model's medium
/// surface, high-passed, [texels] mm. `medium`: the model's values of this frame, [3][medium texels].
class FineTarget {
public:
    FineTarget(const model::DetailModel& model, double sigma, FineOver over);
    void compute(const Scan& scan, PointsRef base, const float* medium, float* out) const;

private:
    const model::DetailModel& model_;
    double sigma_;
    FineOver over_;
    model::MediumSurface surface_;
    std::vector<model::DomainSampler::Sample> samples_;  // of every fine texel in the medium map
    std::vector<TexelMap::Texel> medium_where_, where_;
};

}  // namespace mien::analysis
