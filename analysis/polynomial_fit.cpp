#include "analysis/polynomial_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Core>

#include "core/wide.hpp"

namespace mien::analysis {
namespace {

constexpr int kMost = 16;            // predictors
constexpr double kIndistinct = 1e-9; // share of a predictor's square that is its own; below it, rounding

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

/// Solves the semidefinite A x = b by L D L' in order; unknowns whose pivot is nothing beside `scale` become 0.
Vector solve_in_order(Matrix A, Vector b, const Vector& scale) {
    const Eigen::Index n = A.rows();
    std::vector<char> kept(std::size_t(n), 1);
    for (Eigen::Index k = 0; k < n; ++k) {
        if (!(A(k, k) > kIndistinct * scale[k])) {
            kept[std::size_t(k)] = 0;
            continue;
        }
        for (Eigen::Index i = k + 1; i < n; ++i) {
            const double factor = A(i, k) / A(k, k);
            for (Eigen::Index j = k + 1; j < n; ++j) A(i, j) -= factor * A(k, j);
            b[i] -= factor * b[k];
        }
    }
    Vector x = Vector::Zero(n);
    for (Eigen::Index k = n - 1; k >= 0; --k) {
        if (!kept[std::size_t(k)]) continue;
        double rest = b[k];
        for (Eigen::Index j = k + 1; j < n; ++j) rest -= A(k, j) * x[j];
        x[k] = rest / A(k, k);
    }
    return x;
}

/// Sum of a b, four by four so that it is the same on every processor.
[[gnu::always_inline]] inline double dot(const double* a, const double* b) {
    double sums[4] = {0, 0, 0, 0};
    for (int f = 0; f < NormalEquations::kTogether; f += 4)
        for (int l = 0; l < 4; ++l) sums[l] += a[f + l] * b[f + l];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

MIEN_LOOP add_products_loop(const double* x, const double* y, const double* w, int predictors, int values, double* at) {
    constexpr int n = NormalEquations::kTogether;
    double weighted[kMost * n], one[n];
    for (int f = 0; f < n; ++f) one[f] = 1;
    for (int i = 0; i < predictors; ++i)
        for (int f = 0; f < n; ++f) weighted[i * n + f] = w[f] * x[i * n + f];
    *at++ += dot(w, one);
    for (int i = 0; i < predictors; ++i)
        for (int j = i; j < predictors; ++j) *at++ += dot(weighted + i * n, x + j * n);
    for (int v = 0; v < values; ++v)
        for (int i = 0; i < predictors; ++i) *at++ += dot(weighted + i * n, y + v * n);
    for (int v = 0; v < values; ++v) {
        double wy[n];
        for (int f = 0; f < n; ++f) wy[f] = w[f] * y[v * n + f];
        *at++ += dot(wy, y + v * n);
    }
}
MIEN_WIDE(add_products, (const double* x, const double* y, const double* w, int predictors, int values, double* at), (x, y, w, predictors, values, at))

}  // namespace

NormalEquations::NormalEquations(int predictors, int values)
    : predictors_(predictors), values_(values), xy_(std::size_t(1 + predictors * (predictors + 1) / 2)),
      yy_(xy_ + std::size_t(predictors * values)) {
    assert(predictors >= 1 && predictors <= kMost && values >= 1);
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

void NormalEquations::add_together(std::span<double> sums, const double* x, const double* y, const double* weights) const {
    add_products(x, y, weights, predictors_, values_, sums.data());
}

double NormalEquations::moment(std::span<const double> sums, int i, int j) const {
    if (i > j) std::swap(i, j);
    return sums[std::size_t(1 + i * predictors_ - i * (i - 1) / 2 + (j - i))];
}

void NormalEquations::solve(std::span<const double> sums, int value, int terms, std::span<const int> degree, const Ridge& ridge, double* out) const {
    assert(terms <= predictors_ && int(degree.size()) >= terms);
    std::fill_n(out, terms, 0.0);
    const double n = count(sums);
    if (!(n > 0)) return;
    Matrix G(terms, terms);
    Vector b(terms);
    for (int i = 0; i < terms; ++i) {
        b[i] = sums[xy_ + std::size_t(value * predictors_ + i)];
        for (int j = 0; j < terms; ++j) G(i, j) = moment(sums, i, j);
    }
    const Vector scale = G.diagonal();
    const double strength[4] = {0, n * ridge.linear, n * ridge.quadratic, n * ridge.cubic};
    int low = 0;  // terms of degree 0 and 1 come first
    while (low < terms && degree[std::size_t(low)] <= 1) ++low;
    Vector x;
    if (!ridge.orthogonal || low == terms) {
        for (int i = 0; i < terms; ++i) G(i, i) += strength[degree[std::size_t(i)]];
        x = solve_in_order(G, b, scale);
    } else {
        // High terms orthogonal to the low ones: N' = N - L A, A = (L'L)^-1 L'N. The problem falls into two.
        const int high = terms - low;
        const Matrix LL = G.topLeftCorner(low, low);
        Matrix A(low, high);
        for (int k = 0; k < high; ++k) A.col(k) = solve_in_order(LL, G.col(low + k).head(low), scale.head(low));
        Matrix NN = G.bottomRightCorner(high, high) - A.transpose() * G.topRightCorner(low, high);
        const Vector nb = b.tail(high) - A.transpose() * b.head(low);
        Matrix held = LL;
        for (int i = 0; i < low; ++i) held(i, i) += strength[degree[std::size_t(i)]];
        for (int k = 0; k < high; ++k) NN(k, k) += strength[degree[std::size_t(low + k)]];
        const Vector q = solve_in_order(NN, nb, scale.tail(high));
        x.resize(terms);
        x.head(low) = solve_in_order(held, b.head(low), scale.head(low)) - A * q;
        x.tail(high) = q;
    }
    std::copy(x.begin(), x.end(), out);
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
