#include "bench/bd_rate.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace mien::bench {
namespace {

// Slope at the end of the data: of the parabola through three points, held to the sign and three times the size of the
// first secant.
double end_slope(double h0, double h1, double secant0, double secant1) {
    const double slope = ((2 * h0 + h1) * secant0 - h0 * secant1) / (h0 + h1);
    if (slope * secant0 <= 0) return 0;
    if (secant0 * secant1 < 0 && std::abs(slope) > std::abs(3 * secant0)) return 3 * secant0;
    return slope;
}

// log10 rate over quality, ascending, without points that a better one makes pointless.
std::optional<Pchip> curve(std::span<const RatePoint> points, double& lowest, double& highest) {
    std::vector<RatePoint> sorted;
    for (const RatePoint& point : points)
        if (std::isfinite(point.rate) && point.rate > 0 && std::isfinite(point.quality)) sorted.push_back(point);
    std::sort(sorted.begin(), sorted.end(),
              [](const RatePoint& a, const RatePoint& b) { return a.rate != b.rate ? a.rate < b.rate : a.quality > b.quality; });
    std::vector<double> quality, rate;
    for (const RatePoint& point : sorted) {
        if (!quality.empty() && point.quality <= quality.back()) continue;
        quality.push_back(point.quality);
        rate.push_back(std::log10(point.rate));
    }
    if (quality.size() < 2) return {};
    lowest = quality.front();
    highest = quality.back();
    return Pchip(std::move(quality), std::move(rate));
}

}  // namespace

Pchip::Pchip(std::vector<double> x, std::vector<double> y) : x_(std::move(x)), y_(std::move(y)), slope_(x_.size()) {
    const std::size_t n = x_.size();
    assert(n >= 2 && y_.size() == n);
    std::vector<double> h(n - 1), secant(n - 1);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        h[i] = x_[i + 1] - x_[i];
        assert(h[i] > 0);
        secant[i] = (y_[i + 1] - y_[i]) / h[i];
    }
    if (n == 2) {
        slope_[0] = slope_[1] = secant[0];
        return;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
        if (secant[i - 1] * secant[i] <= 0) continue;
        const double before = h[i - 1] + 2 * h[i], after = 2 * h[i - 1] + h[i];
        slope_[i] = (before + after) / (before / secant[i - 1] + after / secant[i]);
    }
    slope_[0] = end_slope(h[0], h[1], secant[0], secant[1]);
    slope_[n - 1] = end_slope(h[n - 2], h[n - 3], secant[n - 2], secant[n - 3]);
}

std::size_t Pchip::piece(double x) const {
    const auto after = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
    return std::size_t(after - x_.begin()) - 1;
}

double Pchip::at(double x) const {
    const std::size_t i = piece(x);
    const double h = x_[i + 1] - x_[i], t = (x - x_[i]) / h, s = 1 - t;
    return y_[i] * (1 + 2 * t) * s * s + h * slope_[i] * t * s * s + y_[i + 1] * (3 - 2 * t) * t * t -
           h * slope_[i + 1] * t * t * s;
}

double Pchip::integral_from_start(double x) const {
    const std::size_t last = piece(x);
    double sum = 0;
    for (std::size_t i = 0; i <= last; ++i) {
        const double h = x_[i + 1] - x_[i], t = i < last ? 1 : (x - x_[i]) / h;
        const double t2 = t * t, t3 = t2 * t, t4 = t3 * t;
        // Integrals of the four Hermite polynomials from 0 to t.
        sum += h * (y_[i] * (t4 / 2 - t3 + t) + y_[i + 1] * (t3 - t4 / 2) + h * slope_[i] * (t4 / 4 - 2 * t3 / 3 + t2 / 2) +
                    h * slope_[i + 1] * (t4 / 4 - t3 / 3));
    }
    return sum;
}

double Pchip::integral(double from, double to) const {
    return integral_from_start(to) - integral_from_start(from);
}

std::optional<double> bd_rate(std::span<const RatePoint> anchor, std::span<const RatePoint> test) {
    double low_a = 0, high_a = 0, low_t = 0, high_t = 0;
    const auto a = curve(anchor, low_a, high_a), t = curve(test, low_t, high_t);
    if (!a || !t) return {};
    const double low = std::max(low_a, low_t), high = std::min(high_a, high_t);
    if (!(high > low)) return {};
    const double difference = (t->integral(low, high) - a->integral(low, high)) / (high - low);
    return 100 * (std::pow(10.0, difference) - 1);
}

}  // namespace mien::bench
