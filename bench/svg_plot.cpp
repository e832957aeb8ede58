#include "bench/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace mien::bench {
namespace {

constexpr double kWidth = 960, kLeft = 64, kRight = 240, kTop = 16, kBottom = 52, kHeight = 400;

/// One axis: value to pixels, and where its lines stand.
class Axis {
public:
    Axis(bool logarithmic, double low, double high, double from, double to) : log_(logarithmic), from_(from), to_(to) {
        low_ = log_ ? std::log10(low) : low;
        high_ = log_ ? std::log10(high) : high;
        const double air = std::max((high_ - low_) * 0.06, log_ ? 0.02 : std::max(1e-9, std::abs(high_) * 0.01));
        low_ -= air;
        high_ += air;
    }
    double at(double value) const { return from_ + ((log_ ? std::log10(value) : value) - low_) / (high_ - low_) * (to_ - from_); }

    std::vector<double> ticks() const {
        std::vector<double> out;
        if (!log_) {
            const double rough = (high_ - low_) / 6, power = std::pow(10, std::floor(std::log10(rough)));
            const double step = rough / power < 1.5   ? power
                                : rough / power < 3.5 ? 2 * power
                                : rough / power < 7.5 ? 5 * power
                                                      : 10 * power;
            for (double t = std::ceil(low_ / step) * step; t <= high_; t += step) out.push_back(std::abs(t) < step / 2 ? 0 : t);
            return out;
        }
        // As many of them as there is room for.
        const std::vector<double> leads[] = {{1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8}, {1, 2, 3, 5, 7}, {1, 2, 5}, {1}};
        for (const auto& lead : leads) {
            out.clear();
            for (double power = std::floor(low_); power <= high_; ++power)
                for (const double digit : lead)
                    if (const double t = digit * std::pow(10, power); std::log10(t) >= low_ && std::log10(t) <= high_)
                        out.push_back(t);
            if (out.size() <= 10) break;
        }
        return out;
    }

private:
    bool log_;
    double low_, high_, from_, to_;
};

std::string mark(int shape, double x, double y, const std::string& tip, bool strong) {
    const double r = strong ? 5 : 4;
    const std::string title = tip.empty() ? "" : "<title>" + escaped(tip) + "</title>";
    switch (shape % 4) {
        case 1:
            return fmt::format("<rect class=\"m\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\">{}</rect>",
                               x - r * 0.9, y - r * 0.9, 1.8 * r, 1.8 * r, title);
        case 2:
            return fmt::format("<path class=\"m\" d=\"M{:.1f} {:.1f}l{:.1f} {:.1f}h{:.1f}z\">{}</path>", x, y - r * 1.2, r * 1.15,
                               r * 2, -2.3 * r, title);
        case 3:
            return fmt::format("<path class=\"m\" d=\"M{:.1f} {:.1f}l{:.1f} {:.1f}l{:.1f} {:.1f}l{:.1f} {:.1f}z\">{}</path>", x,
                               y - r * 1.3, r * 1.3, r * 1.3, -r * 1.3, r * 1.3, -r * 1.3, -r * 1.3, title);
        default:
            return fmt::format("<circle class=\"m\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\">{}</circle>", x, y, r, title);
    }
}

std::string dash(const PlotSeries& series) {
    return series.mark == 0   ? ""
           : series.mark == 1 ? " stroke-dasharray=\"7 4\""
           : series.mark == 2 ? " stroke-dasharray=\"2 4\""
                              : " stroke-dasharray=\"9 3 2 3\"";
}

}  // namespace

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text)
        out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
    return out;
}

std::string svg_plot(const Plot& plot) {
    std::vector<PlotSeries> all = plot.series;
    double x0 = std::numeric_limits<double>::infinity(), x1 = -x0, y0 = x0, y1 = -x0;
    for (PlotSeries& series : all) {
        std::erase_if(series.points, [&](const PlotSeries::Point& p) {
            return !std::isfinite(p.x) || !std::isfinite(p.y) || (plot.log_x && p.x <= 0) || (plot.log_y && p.y <= 0);
        });
        std::sort(series.points.begin(), series.points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
        for (const auto& p : series.points)
            x0 = std::min(x0, p.x), x1 = std::max(x1, p.x), y0 = std::min(y0, p.y), y1 = std::max(y1, p.y);
    }
    std::erase_if(all, [](const PlotSeries& series) { return series.points.empty(); });
    if (all.empty()) return {};

    const double height = std::max(kHeight, kTop + kBottom + 20.0 * double(all.size()));
    const double bottom = height - kBottom, right = kWidth - kRight;
    const Axis x(plot.log_x, x0, x1, kLeft, right);
    const Axis y(plot.log_y, y0, y1, plot.smaller_on_top ? kTop : bottom, plot.smaller_on_top ? bottom : kTop);

    std::string svg = fmt::format("<svg class=\"plot\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n", kWidth,
                                  height, escaped(plot.title));
    for (const double t : x.ticks())
        svg += fmt::format(
            "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text class=\"tick\" x=\"{0:.1f}\" y=\"{3:.1f}\" "
            "text-anchor=\"middle\">{4:g}</text>\n",
            x.at(t), kTop, bottom, bottom + 18, t);
    for (const double t : y.ticks())
        svg += fmt::format(
            "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text class=\"tick\" x=\"{3:.1f}\" y=\"{4:.1f}\" "
            "text-anchor=\"end\">{5:.6g}</text>\n",
            kLeft, y.at(t), right, kLeft - 8, y.at(t) + 4, t);
    svg += fmt::format("<path class=\"axis\" d=\"M{:.1f} {:.1f}V{:.1f}H{:.1f}\"/>\n", kLeft, kTop, bottom, right);
    svg += fmt::format("<text class=\"label\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", (kLeft + right) / 2,
                       height - 12, escaped(plot.x_title));
    svg += fmt::format("<text class=\"label\" transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                       (kTop + bottom) / 2, escaped(plot.y_title));
    double row = kTop + 12;
    for (const PlotSeries& series : all) {
        svg += fmt::format("<g class=\"series c{}{}\">", series.colour, series.strong ? " strong" : "");
        std::string path;
        for (const auto& p : series.points)
            path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x.at(p.x), y.at(p.y));
        svg += fmt::format("<path class=\"line\"{} d=\"{}\"/>", dash(series), path);
        for (const auto& p : series.points) svg += mark(series.mark, x.at(p.x), y.at(p.y), p.tip, series.strong);
        const double at = right + 20;
        svg += fmt::format(
            "<path class=\"line\"{} d=\"M{:.1f} {:.1f}h28\"/>{}<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text></g>\n",
            dash(series), at, row, mark(series.mark, at + 14, row, "", series.strong), at + 36, row + 4, escaped(series.name));
        row += 20;
    }
    return svg + "</svg>\n";
}

}  // namespace mien::bench
