#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

/// Small functions the head is sculpted with.
namespace mien::samples {

using std::numbers::pi;

inline double square(double x) {
    return x * x;
}
inline double mix(double a, double b, double t) {
    return a + (b - a) * t;
}

/// 0 at `from`, 1 at `to`, flat at both ends; from > to falls.
inline double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

inline double bell(double x, double centre, double width) {
    return std::exp(-0.5 * square((x - centre) / width));
}
inline double bell(double x, double y, double cx, double cy, double wx, double wy) {
    return std::exp(-0.5 * (square((x - cx) / wx) + square((y - cy) / wy)));
}

/// Maximum with a rounded corner of size k (same unit as a and b).
inline double smooth_max(double a, double b, double k) {
    return 0.5 * (a + b + std::sqrt(square(a - b) + k * k));
}

/// A natural cubic spline through (x_i, y_i), x ascending; straight beyond its ends.
class Spline {
public:
    Spline() = default;
    Spline(std::vector<double> x, std::vector<double> y)
        : x_(std::move(x)), y_(std::move(y)), m_(x_.size(), 0.0) {
        const std::size_t n = x_.size();
        std::vector<double> c(n, 0.0), d(n, 0.0);  // Thomas algorithm on the second derivatives
        for (std::size_t i = 1; i + 1 < n; ++i) {
            const double h0 = x_[i] - x_[i - 1], h1 = x_[i + 1] - x_[i];
            const double right = 6 * ((y_[i + 1] - y_[i]) / h1 - (y_[i] - y_[i - 1]) / h0);
            const double pivot = 2 * (h0 + h1) - h0 * c[i - 1];
            c[i] = h1 / pivot;
            d[i] = (right - h0 * d[i - 1]) / pivot;
        }
        for (std::size_t i = n - 1; i-- > 1;) m_[i] = d[i] - c[i] * m_[i + 1];
    }
    double operator()(double x) const {
        const std::size_t n = x_.size();
        std::size_t i = std::upper_bound(x_.begin(), x_.end(), x) - x_.begin();
        i = std::clamp<std::size_t>(i, 1, n - 1);
        const double h = x_[i] - x_[i - 1];
        if (x < x_.front()) return y_[0] + (x - x_[0]) * ((y_[1] - y_[0]) / h - h * m_[1] / 6);
        if (x > x_.back())
            return y_[n - 1] + (x - x_[n - 1]) * ((y_[n - 1] - y_[n - 2]) / h + h * m_[n - 2] / 6);
        const double a = (x_[i] - x) / h, b = 1 - a;
        return a * y_[i - 1] + b * y_[i] +
               ((a * a * a - a) * m_[i - 1] + (b * b * b - b) * m_[i]) * h * h / 6;
    }

private:
    std::vector<double> x_, y_, m_;
};

}  // namespace mien::samples
