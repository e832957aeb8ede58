#pragma once

#include <string>
#include <vector>

namespace mien::bench {

struct PlotSeries {
    std::string name;
    int colour = 0;  ///< 0 .. 7, of the page's palette
    int mark = 0;    ///< 0 .. 3: circle, square, triangle, diamond; lines of 1 and up are dashed
    bool strong = false;
    struct Point {
        double x, y;
        std::string tip;  ///< shown when the mouse rests on it
    };
    std::vector<Point> points;
};

struct Plot {
    std::string title, x_title, y_title;
    bool log_x = true, log_y = false;
    bool smaller_on_top = false;  ///< for errors: up is always better
    std::vector<PlotSeries> series;
};

/// An <svg> element that takes its colours from the page's CSS variables. Points that are not finite (or not positive on a
/// logarithmic axis) are left out; empty when nothing is left.
std::string svg_plot(const Plot& plot);

std::string escaped(const std::string& text);  ///< for HTML and SVG

}  // namespace mien::bench
