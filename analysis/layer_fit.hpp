#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "analysis/polynomial_fit.hpp"

namespace mien::analysis {

/// The least-squares problems of all texels of a layer for one kind of predictors, gathered frame by frame. Memory is one set
/// of sums per texel, whatever the number of frames; a few thousand texels also keep theirs apart by fold, for choosing
/// strengths.
class LayerFit {
public:
    LayerFit(int predictors, int values, std::size_t texels, int folds);

    /// One frame of a batch.
    struct Frame {
        const float* values;   ///< [value][texel]; a sample with a NaN counts for nothing
        int fold;              ///< that it belongs to
    };
    /// Writes a texel's predictors for all frames of a batch, x[predictors][NormalEquations::padded(frames)]; what lies behind the last frame may be
    /// any finite number. Called from several threads.
    using Drive = std::function<void(std::uint32_t texel, double* x)>;
    void add(const std::vector<Frame>& batch, const Drive& drive);

    std::size_t texels() const { return texels_; }
    int values() const { return equations_.values(); }
    double count(std::size_t texel) const { return sums_[texel * equations_.size()]; }
    void keep(const std::vector<std::uint32_t>& texels);  ///< drops all others; ascending

    /// Empties the sums. From here on a sample weighs 1 / sqrt(1 + e² / scale²), e its distance from what `planes` (as of solve, of the
    /// first `terms` predictors) says: with every round of gathering and solving, least squares turns towards least distances
    /// (iteratively reweighted least squares; Holland and Welsch 1977).
    void reweigh(std::vector<float> planes, int terms, double scale);
    /// Median over texels of the RMS distance that the fit itself leaves.
    double typical_error(int terms, const std::vector<int>& degrees, const Ridge& ridge) const;
    /// RMS of independent noise that raises the mean distance which the fit itself leaves by `share`, each texel's errors taken as normal.
    double noise_for(double share, int terms, const std::vector<int>& degrees, const Ridge& ridge) const;

    /// Distance that is left when each fold in turn is left out of the fit, mean over texels of the RMS over values and frames as
    /// weighted; with one fold only, of the fit itself.
    double left_out_error(int terms, const std::vector<int>& degrees, const Ridge& ridge) const;
    /// Coefficients [value][term][texel].
    std::vector<float> solve(int terms, const std::vector<int>& degrees, const Ridge& ridge) const;

private:
    /// RMS distance that the fit leaves, of some thousand texels.
    std::vector<double> errors(int terms, const std::vector<int>& degrees, const Ridge& ridge) const;
    std::span<const double> sums(std::size_t texel) const { return {sums_.data() + texel * equations_.size(), equations_.size()}; }
    std::size_t sparse_at(int fold, std::size_t k) const { return (std::size_t(fold) * sparse_.size() + k) * equations_.size(); }

    NormalEquations equations_;
    std::size_t texels_;
    int folds_;
    std::vector<double> sums_;                // [texel]
    std::vector<std::uint32_t> sparse_;       // texels that are also kept by fold, ascending
    std::vector<double> by_fold_;             // [fold][sparse]
    std::vector<float> planes_;               // that samples are weighed by; empty: all alike
    int terms_ = 0;
    double scale_ = 0;
};

/// Strengths with the least left-out error, one degree after the other: linear terms alone, then with the quadratic ones added, then
/// the cubic, as far as `terms` goes. With fewer than three takes there is too little to choose by: the defaults.
Ridge choose_ridge(const LayerFit& fit, int terms, const std::vector<int>& degrees, int takes);

/// When there is nothing to choose by.
inline constexpr Ridge kDefaultRidge{1e-3, 0.3, 0.3, true};

}  // namespace mien::analysis
