#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "model/polynomial_map.hpp"

namespace mien::analysis {

/// How strongly coefficients are held towards zero, per training frame (d1 and d2 have unit RMS): Ma et al. 2008, section 4.2
/// has one small γ on all of a0 .. a4. Ours differ by degree, and the terms of degree 2 and more are first made orthogonal
/// to 1, d1, d2 over the texel's own frames, so that what linear terms explain is not held back with them.
struct Ridge {
    double linear = 0;
    double quadratic = 0;
    double cubic = 0;
    bool orthogonal = true;  ///< false: the paper's way, on the terms as they are
};

/// Sums of a weighted least-squares problem: any number of predictors x (the first is the constant 1), any number of values y.
/// Laid out flat, so that a million texels are one array: n, the sum of all weights; x x' (upper triangle by rows); x y' by value; y².
class NormalEquations {
public:
    NormalEquations(int predictors, int values);
    std::size_t size() const { return size_; }
    int predictors() const { return predictors_; }
    int values() const { return values_; }

    /// Adds one sample to sums of size().
    void add(std::span<double> sums, const double* x, const double* y, double weight = 1) const;
    /// Samples are added together by so many, or by a multiple of it.
    static constexpr int kTogether = 16;
    static constexpr int padded(std::size_t samples) { return int((samples + kTogether - 1) / kTogether) * kTogether; }
    /// Adds n samples, a multiple of kTogether: x [predictors][n], y [values][n], weights [n]. As add() one by one, but for rounding; a sample of weight
    /// 0 counts for nothing, if its numbers are finite.
    void add_together(std::span<double> sums, int n, const double* x, const double* y, const double* weights) const;
    /// Least squares of every value on the first `terms` predictors: out[values][terms]. Predictors that the samples do not tell
    /// apart from earlier ones get 0. `degree[k]`: of predictor k (0, 1, 2, 3), for the ridge.
    void solve(std::span<const double> sums, int terms, std::span<const int> degree, const Ridge& ridge, double* out) const;
    /// Sum of squared errors of `coefficients` over the gathered samples.
    double squared_error(std::span<const double> sums, int value, int terms, const double* coefficients) const;
    double count(std::span<const double> sums) const { return sums[0]; }

private:
    double moment(std::span<const double> sums, int i, int j) const;

    int predictors_, values_;
    std::size_t size_, xy_, yy_;  // offsets
};

/// Degrees of the polynomial terms (PolynomialOrder) and of `n` linear predictors after the constant.
std::vector<int> polynomial_degrees();
std::vector<int> linear_degrees(int n);

}  // namespace mien::analysis
