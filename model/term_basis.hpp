#pragma once

#include <vector>

#include <Eigen/Core>

#include "model/polynomial_map.hpp"

namespace mien::model {

/// Means of d1^i d2^j over the training frames at every marker: M rows, i + j <= 2 x 3, ordered as polynomial terms are (by degree, then by
/// the power of d2). The first column is 1.
using TermMoments = Eigen::Matrix<double, Eigen::Dynamic, (2 * 3 + 1) * (2 * 3 + 2) / 2, Eigen::RowMajor>;
/// The column of d1^i d2^j.
constexpr int moment_column(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

/// Adds one frame's d1, d2 at every marker, weighted by 1 / frames.
void add_term_moments(TermMoments& moments, const DomainAxes& axes, const Deformations& S, double weight);

/// Lower triangles L_m by rows, one per marker, with L_m L_m' the second moments of the polynomial terms there. Diagonals are positive.
struct TermFactors {
    int terms = 0;
    std::vector<float> values;  ///< [M][terms (terms + 1) / 2]

    static std::size_t size(int terms) { return std::size_t(terms) * std::size_t(terms + 1) / 2; }
    const float* at(std::size_t marker) const { return values.data() + marker * size(terms); }
};

/// Factors of the moments, `spread` times those of independent normal d1, d2 of the same power added: coefficients are also held where
/// unseen frames go.
TermFactors term_factors(const TermMoments& moments, PolynomialOrder order, double spread);

/// Coefficients c of a map in the basis that is orthonormal over the training frames: at every texel L' c, L interpolated over the
/// texel's marker triangle. An error there is the same error of the values, whichever term it is in. Of L the leading
/// term_count(map.order) rows count.
void to_trained_basis(PolynomialMap& map, const DomainMap& domain, const std::vector<Triangle>& marker_triangles, const TermFactors& factors);
void from_trained_basis(PolynomialMap& map, const DomainMap& domain, const std::vector<Triangle>& marker_triangles, const TermFactors& factors);

}  // namespace mien::model
