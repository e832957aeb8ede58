#pragma once

#include <optional>
#include <span>
#include <vector>

namespace mien::bench {

/// Piecewise cubic Hermite interpolation that keeps monotone data monotone: the slopes of Fritsch and Butland 1984 (weighted
/// harmonic means), one-sided three-point slopes at the ends, as MATLAB's and SciPy's `pchip`.
class Pchip {
public:
    /// x strictly ascending, as many as y, at least two.
    Pchip(std::vector<double> x, std::vector<double> y);

    double at(double x) const;                      ///< x within the data
    double integral(double from, double to) const;  ///< both within the data, exact

private:
    double integral_from_start(double x) const;
    std::size_t piece(double x) const;

    std::vector<double> x_, y_, slope_;
};

struct RatePoint {
    double rate = 0;     ///< > 0, in any unit
    double quality = 0;  ///< higher is better
};

/// Bjontegaard delta rate, percent: how much more rate `test` needs than `anchor` for the same quality, on average over the
/// qualities that both reach (VCEG-M33; log10 of the rate over quality by PCHIP, as the JCT-VC and JVET test conditions have
/// it). Points that another point of their curve beats in both rate and quality are left out. None when fewer than two
/// points are left in a curve or the curves share no range of quality.
std::optional<double> bd_rate(std::span<const RatePoint> anchor, std::span<const RatePoint> test);

}  // namespace mien::bench
