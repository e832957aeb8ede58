#include "analysis/polynomial_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "core/wide.hpp"

namespace mien::analysis {
namespace {

constexpr int kMost = 16;            // predictors
constexpr double kIndistinct = 1e-9; // share of a predictor's square that is its own; below it, rounding

constexpr int kMostValues = 4;

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMost, kMost>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

/// Solves the semidefinite A X = B by L D L' in order; unknowns whose pivot is nothing beside `scale` become 0.
Matrix solve_in_order(Matrix A, Matrix B, const Vector& scale) {
    const Eigen::Index n = A.rows(), sides = B.cols();
    bool kept[kMost];
    for (Eigen::Index k = 0; k < n; ++k) {
        kept[k] = A(k, k) > kIndistinct * scale[k];
        if (!kept[k]) continue;
        for (Eigen::Index i = k + 1; i < n; ++i) {
            const double factor = A(i, k) / A(k, k);
            for (Eigen::Index j = k + 1; j < n; ++j) A(i, j) -= factor * A(k, j);
            for (Eigen::Index s = 0; s < sides; ++s) B(i, s) -= factor * B(k, s);
        }
    }
    Matrix X = Matrix::Zero(n, sides);
    for (Eigen::Index k = n - 1; k >= 0; --k) {
        if (!kept[k]) continue;
        for (Eigen::Index s = 0; s < sides; ++s) {
            double rest = B(k, s);
            for (Eigen::Index j = k + 1; j < n; ++j) rest -= A(k, j) * X(j, s);
            X(k, s) = rest / A(k, k);
        }
    }
    return X;
}

/// Sum of a b over n samples, lane by lane so that it is the same on every processor.
[[gnu::always_inline]] inline double dot(const double* a, const double* b, int n) {
    constexpr int lanes = NormalEquations::kTogether;
    double sums[lanes];
    for (int l = 0; l < lanes; ++l) sums[l] = a[l] * b[l];
    for (int f = lanes; f < n; f += lanes)
        for (int l = 0; l < lanes; ++l) sums[l] += a[f + l] * b[f + l];
    for (int half = lanes / 2; half > 0; half /= 2)
        for (int l = 0; l < half; ++l) sums[l] += sums[l + half];
    return sums[0];
}

MIEN_LOOP add_products_loop(const double* x, const double* y, const double* w, int n, int predictors, int values, double* weighted, double* at) {
    double* const one = weighted + predictors * n;
    for (int f = 0; f < n; ++f) one[f] = 1;
    for (int i = 0; i < predictors; ++i)
        for (int f = 0; f < n; ++f) weighted[i * n + f] = w[f] * x[i * n + f];
    *at++ += dot(w, one, n);
    for (int i = 0; i < predictors; ++i)
        for (int j = i; j < predictors; ++j) *at++ += dot(weighted + i * n, x + j * n, n);
    for (int v = 0; v < values; ++v)
        for (int i = 0; i < predictors; ++i) *at++ += dot(weighted + i * n, y + v * n, n);
    for (int v = 0; v < values; ++v) {
        for (int f = 0; f < n; ++f) one[f] = w[f] * y[v * n + f];
        *at++ += dot(one, y + v * n, n);
    }
}
MIEN_WIDE(add_products, (const double* x, const double* y, const double* w, int n, int predictors, int values, double* weighted, double* at),
          (x, y, w, n, predictors, values, weighted, at))

}  // namespace

NormalEquations::NormalEquations(int predictors, int values)
    : predictors_(predictors), values_(values), xy_(std::size_t(1 + predictors * (predictors + 1) / 2)),
      yy_(xy_ + std::size_t(predictors * values)) {
    assert(predictors >= 1 && predictors <= kMost && values >= 1 && values <= kMostValues);
    size_ = yy_ + std::size_t(values);
}

void NormalEquations::add(std::span<double> sums, const double* x, const double* y, double weight) const {
    double* at = sums.data();
    *at++ += weight;
    for (int i = 0; i < predictors_; ++i)
        for (int j = i; j < predictors_; ++j) *at++ += weight * x[i] * x[j];
    for (int v = 0; v < values_; ++v)
        for (int i = 0; i < predictors_; ++i) *at++ += weight * x[i] * y[v];
    for (int v = 0; v < values_; ++v) *at++ += weight * y[v] * y[v];
}

void NormalEquations::add_together(std::span<double> sums, int n, const double* x, const double* y, const double* weights) const {
    assert(n > 0 && n % kTogether == 0);
    static thread_local std::vector<double> weighted;
    weighted.resize(std::size_t((predictors_ + 1) * n));
    add_products(x, y, weights, n, predictors_, values_, weighted.data(), sums.data());
}

double NormalEquations::moment(std::span<const double> sums, int i, int j) const {
    if (i > j) std::swap(i, j);
    return sums[std::size_t(1 + i * predictors_ - i * (i - 1) / 2 + (j - i))];
}

void NormalEquations::solve(std::span<const double> sums, int terms, std::span<const int> degree, const Ridge& ridge, double* out) const {
    assert(terms <= predictors_ && int(degree.size()) >= terms);
    std::fill_n(out, values_ * terms, 0.0);
    const double n = count(sums);
    if (!(n > 0)) return;
    Matrix G(terms, terms), b(terms, values_);
    for (int i = 0; i < terms; ++i) {
        for (int v = 0; v < values_; ++v) b(i, v) = sums[xy_ + std::size_t(v * predictors_ + i)];
        for (int j = i; j < terms; ++j) G(i, j) = G(j, i) = moment(sums, i, j);
    }
    const Vector scale = G.diagonal();
    const double strength[4] = {0, n * ridge.linear, n * ridge.quadratic, n * ridge.cubic};
    int low = 0;  // terms of degree 0 and 1 come first
    while (low < terms && degree[std::size_t(low)] <= 1) ++low;
    Matrix x(terms, values_);
    if (!ridge.orthogonal || low == terms) {
        for (int i = 0; i < terms; ++i) G(i, i) += strength[degree[std::size_t(i)]];
        x = solve_in_order(G, b, scale);
    } else {
        // High terms orthogonal to the low ones: N' = N - L A, A = (L'L)^-1 L'N. The problem falls into two.
        const int high = terms - low;
        Matrix held = G.topLeftCorner(low, low);
        const Matrix LN = G.topRightCorner(low, high), A = solve_in_order(held, LN, scale.head(low));
        Matrix NN = G.bottomRightCorner(high, high), nb = b.bottomRows(high);
        NN -= A.transpose().lazyProduct(LN);
        nb -= A.transpose().lazyProduct(b.topRows(low));
        for (int i = 0; i < low; ++i) held(i, i) += strength[degree[std::size_t(i)]];
        for (int k = 0; k < high; ++k) NN(k, k) += strength[degree[std::size_t(low + k)]];
        const Matrix q = solve_in_order(NN, nb, scale.tail(high));
        x.topRows(low) = solve_in_order(held, b.topRows(low), scale.head(low)) - A.lazyProduct(q);
        x.bottomRows(high) = q;
    }
    for (int v = 0; v < values_; ++v)
        for (int k = 0; k < terms; ++k) out[v * terms + k] = x(k, v);
}

double NormalEquations::squared_error(std::span<const double> sums, int value, int terms, const double* coefficients) const {
    double error = sums[yy_ + std::size_t(value)];
    for (int i = 0; i < terms; ++i) {
        error -= 2 * coefficients[i] * sums[xy_ + std::size_t(value * predictors_ + i)];
        for (int j = 0; j < terms; ++j) error += coefficients[i] * coefficients[j] * moment(sums, i, j);
    }
    return std::max(0.0, error);
}

std::vector<int> polynomial_degrees() { return {0, 1, 1, 2, 2, 2, 3, 3, 3, 3}; }

std::vector<int> linear_degrees(int n) {
    std::vector<int> degrees(std::size_t(n + 1), 1);
    degrees[0] = 0;
    return degrees;
}

}  // namespace mien::analysis
