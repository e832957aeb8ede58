#pragma once

#include "bench/report.hpp"
#include "bench/svg_plot.hpp"

namespace mien::bench {

// The plots of one clip; without series when there is nothing to plot.
Plot motion_plot(const Report& report, const ClipFacts& clip);
Plot texture_plot(const Report& report, const ClipFacts& clip);
Plot view_plot(const Report& report, const ClipFacts& clip);

}  // namespace mien::bench
