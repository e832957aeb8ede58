#include "bench/report_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "bench/report_tables.hpp"

namespace mien::bench {
namespace {

/// Colours by family, so that one library looks alike everywhere; marks tell its members apart.
int family(const std::string& name) {
    constexpr std::array<const char*, 7> kFamilies{"mien", "guenter98", "draco", "meshopt", "zstd", "xz", "raw"};
    for (std::size_t i = 0; i < kFamilies.size(); ++i)
        if (name.starts_with(kFamilies[i])) return int(i);
    return 7;
}

int texture_colour(const std::string& codec) {
    constexpr std::array<const char*, 4> kCodecs{"mpeg4", "h264", "hevc", "av1"};
    for (std::size_t i = 0; i < kCodecs.size(); ++i)
        if (codec == kCodecs[i]) return std::array{2, 0, 3, 1}[i];
    return 7;
}

PlotSeries& find(std::vector<PlotSeries>& all, const std::string& name) {
    for (PlotSeries& series : all)
        if (series.name == name) return series;
    all.push_back({});
    all.back().name = name;
    return all.back();
}

}  // namespace

Plot motion_plot(const Report& report, const ClipFacts& clip) {
    const bool weights = clip.kind == "weights";
    Plot plot{"Motion of " + clip.name,
              "kbit/s",
              weights ? "RMS error, weight units (up is better)" : "RMS error, mm (up is better)",
              true,
              true,
              true,
              {}};
    std::map<int, std::vector<std::string>> members;
    for (const GeometryRow& row : report.geometry) {
        if (row.clip != clip.key || !row.failed.empty() || !(row.rms > 0)) continue;
        const std::string name = shown_codec(report, row.codec, row.library);
        PlotSeries& series = find(plot.series, name);
        series.colour = family(row.codec);
        auto& names = members[series.colour];
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        series.mark = int(std::find(names.begin(), names.end(), name) - names.begin()) % 4;
        series.strong = is_ours(row.codec);
        series.points.push_back(
            {row.kbps, row.rms,
             fmt::format("{}: {} kbit/s, RMS {}, peak {}", name, figure(row.kbps, 4), figure(row.rms, 3), figure(row.peak, 3))});
    }
    return plot;
}

Plot texture_plot(const Report& report, const ClipFacts& clip) {
    Plot plot{"Texture of " + clip.name, "kbit/s", "PSNR-Y in used texels, dB", true, false, false, {}};
    for (const TextureRow& row : report.texture) {
        if (row.clip != clip.key || !row.failed.empty()) continue;
        const std::string name = row.series == "mien" ? "mien, " + row.codec : row.codec + ", plain";
        PlotSeries& series = find(plot.series, name);
        series.colour = texture_colour(row.codec);
        series.mark = row.series == "mien" ? 0 : 1;
        series.strong = row.series == "mien";
        series.points.push_back({row.kbps, row.psnr_y,
                                 fmt::format("{}: {} kbit/s, {} dB, SSIM {}", name, figure(row.kbps, 4), figure(row.psnr_y, 4),
                                             figure(row.ssim, 4))});
    }
    return plot;
}

Plot view_plot(const Report& report, const ClipFacts& clip) {
    Plot plot{"Drawn views of " + clip.name, "kbit/s, motion and texture", "PSNR-Y in face pixels, dB", true, false, false, {}};
    for (const ViewRow& row : report.views) {
        if (row.clip != clip.key || !row.failed.empty()) continue;
        const std::string name = row.geometry + " + " + row.texture + (row.series == "mien" ? "" : ", plain");
        PlotSeries& series = find(plot.series, name);
        series.colour = texture_colour(row.texture);
        series.strong = is_ours(row.geometry) && row.series == "mien";
        series.mark = series.strong ? 0 : is_ours(row.geometry) ? 1 : 2;
        series.points.push_back({row.kbps, row.psnr_y,
                                 fmt::format("{}: {} kbit/s, {} dB, SSIM {}", name, figure(row.kbps, 4), figure(row.psnr_y, 4),
                                             figure(row.ssim, 4))});
    }
    return plot;
}

}  // namespace mien::bench
