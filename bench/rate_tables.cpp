#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "bench/bd_rate.hpp"
#include "bench/report_tables.hpp"

// Tables of rate against error: motion, texture, drawn views.
namespace mien::bench {
namespace {

using Series = std::pair<std::string, std::string>;  // codec, library

std::string percent(const std::optional<double>& value) {
    return value ? fmt::format("{:+.1f} %", *value) : "-";
}

/// Codecs of a clip in order of appearance, ours first as they were run.
std::vector<Series> series_of(const Report& report, const ClipFacts& clip) {
    std::vector<Series> series;
    for (const GeometryRow& row : report.geometry)
        if (row.clip == clip.key && std::find(series.begin(), series.end(), Series{row.codec, row.library}) == series.end())
            series.emplace_back(row.codec, row.library);
    return series;
}

std::vector<RatePoint> motion_curve(const Report& report, const ClipFacts& clip, const Series& series) {
    std::vector<RatePoint> points;
    for (const GeometryRow& row : report.geometry)
        if (row.clip == clip.key && row.codec == series.first && row.library == series.second && row.failed.empty() &&
            row.rms > 0)
            points.push_back({row.kbps, -20 * std::log10(row.rms)});
    return points;
}

Table motion_pivot(const Report& report, const ClipFacts& clip, const std::vector<Series>& all) {
    std::set<double, std::greater<>> asked;
    for (const GeometryRow& row : report.geometry)
        if (row.clip == clip.key && row.asked_rms > 0) asked.insert(row.asked_rms);
    Table table;
    table.title = "Motion: kbit/s by asked RMS error";
    table.note =
        "Everything that moves the points, as stored; framing, connectivity and texture coordinates apart. Every figure belongs "
        "to bytes that were decoded and "
        "measured. The last column: Bjontegaard delta rate of mien (mien-live for live codecs, mien-whole for others) against "
        "the row, PCHIP over -20 log10 RMS; "
        "negative is fewer bits.";
    table.columns = {"codec", "mode"};
    for (const double rms : asked) table.columns.push_back(figure(rms, 3));
    table.columns.push_back("mien's BD-rate");
    for (const Series& series : all) {
        Table::Row line{{shown_codec(report, series.first, series.second)}, is_ours(series.first)};
        std::string mode;
        std::map<double, std::string> cells;
        for (const GeometryRow& row : report.geometry) {
            if (row.clip != clip.key || Series{row.codec, row.library} != series) continue;
            mode = row.mode;
            cells[row.asked_rms] = row.failed.empty() ? figure(row.kbps, 4) : "failed";
        }
        line.cells.push_back(mode);
        for (const double rms : asked) line.cells.push_back(cells.count(rms) ? cells[rms] : cells.count(0) ? cells[0] : "-");
        std::string against = "-";
        if (!line.ours) {
            const std::string subject = mode == "live" ? "mien-live" : "mien-whole";
            for (const Series& ours : all)
                if (ours.first == subject)
                    against = percent(bd_rate(motion_curve(report, clip, series), motion_curve(report, clip, ours)));
        }
        line.cells.push_back(against);
        table.rows.push_back(std::move(line));
    }
    return table;
}

Table motion_split(const Report& report, const ClipFacts& clip) {
    Table table;
    table.title = "Where mien's bits go, kbit/s";
    table.columns = {"codec", "RMS asked", "shape",   "basis", "probabilities", "coefficients",
                     "pose",  "sum",       "framing", "RMS",   "peak",          "KG %"};
    for (const GeometryRow& row : report.geometry) {
        if (row.clip != clip.key || !row.failed.empty() || !(is_ours(row.codec) || row.codec == "guenter98")) continue;
        const double to_kbps = row.bytes ? row.kbps / double(row.bytes) : 0;
        const auto part = [&](const Parts& parts, const std::string& name) -> std::string {
            for (const auto& [what, bytes] : parts)
                if (what == name) return figure(double(bytes) * to_kbps, 4);
            return "-";
        };
        Table::Row line{{row.codec, figure(row.asked_rms, 3)}, is_ours(row.codec)};
        for (const char* name : {"shape", "basis", "probabilities", "coefficients", "pose"})
            line.cells.push_back(part(row.parts, name));
        line.cells.insert(line.cells.end(), {figure(row.kbps, 4), part(row.apart, "framing"), figure(row.rms, 4),
                                             figure(row.peak, 3), figure(row.kg, 4)});
        table.rows.push_back(std::move(line));
    }
    return table;
}

Table motion_details(const Report& report, const ClipFacts& clip) {
    Table table;
    table.title = "Every motion row";
    table.details = true;
    table.columns = {"codec", "library", "mode", "RMS asked", "bytes", "kbit/s", "bits/point/frame", "RMS", "peak", "KG %"};
    for (const GeometryRow& row : report.geometry) {
        if (row.clip != clip.key) continue;
        Table::Row line{{row.codec, row.library, row.mode, row.asked_rms > 0 ? figure(row.asked_rms, 3) : "-"},
                        is_ours(row.codec)};
        if (row.failed.empty())
            line.cells.insert(line.cells.end(),
                              {std::to_string(row.bytes), figure(row.kbps, 5), figure(row.bits_per_vertex_frame, 4),
                               figure(row.rms, 4), figure(row.peak, 4), figure(row.kg, 4)});
        else line.cells.insert(line.cells.end(), {row.failed, "", "", "", "", ""});
        table.rows.push_back(std::move(line));
    }
    return table;
}

}  // namespace

std::vector<Table> geometry_tables(const Report& report, const ClipFacts& clip) {
    const auto all = series_of(report, clip);
    if (all.empty()) return {};
    return {motion_pivot(report, clip, all), motion_split(report, clip), motion_details(report, clip)};
}

std::vector<Table> texture_tables(const Report& report, const ClipFacts& clip) {
    Table rates, rows;
    rates.title = "Texture: Bjontegaard delta rate over PSNR-Y";
    rates.note =
        "mien's texture against the plain libavcodec encoder at the same preset, given the same filled texture, rate control and "
        "group length; and every plain "
        "encoder against plain H.264. Negative is fewer bits.";
    rates.columns = {"codec", "mien against plain", "plain against plain h264"};
    rows.title = "Texture: every row";
    rows.note = "PSNR-Y and SSIM inside the used texels, from decoded pictures; worst: the single frame with the lowest PSNR-Y; "
                "pulse: by how much the first frame of a group is better than the one before it, mean over groups.";
    rows.columns = {"codec", "series", "asked kbit/s", "kbit/s", "PSNR-Y dB", "SSIM", "worst dB", "pulse dB"};
    rows.details = true;
    std::map<std::string, std::map<std::string, std::vector<RatePoint>>> curves;
    for (const TextureRow& row : report.texture) {
        if (row.clip != clip.key) continue;
        Table::Row line{{row.codec, row.series, figure(row.asked_kbps, 4)}, row.series == "mien"};
        if (row.failed.empty()) {
            line.cells.insert(line.cells.end(),
                              {figure(row.kbps, 4), figure(row.psnr_y, 4), figure(row.ssim, 4), figure(row.worst_psnr_y, 4),
                               fmt::format("{:+.2f}", row.pulse)});
            curves[row.codec][row.series].push_back({row.kbps, row.psnr_y});
        } else {
            line.cells.insert(line.cells.end(), {row.failed, "", "", "", ""});
        }
        rows.rows.push_back(std::move(line));
    }
    if (rows.empty()) return {};
    for (auto& [codec, series] : curves)
        rates.rows.push_back({{codec, percent(bd_rate(series["plain"], series["mien"])),
                               percent(bd_rate(curves["h264"]["plain"], series["plain"]))}});
    return {rates, rows};
}

std::vector<Table> view_tables(const Report& report, const ClipFacts& clip) {
    Table rates, rows;
    rates.title = "Drawn views: Bjontegaard delta rate over PSNR-Y";
    rates.note =
        "Everything received, motion and texture, against the drawn truth in the face's own pixels, from three fixed cameras. "
        "First column of figures: mien's "
        "texture against the plain encoder over texture bits alone, both on mien's motion. Second: all of mien against the best "
        "other motion codec with "
        "the plain encoder, over all bits. Last: the worst single picture of mien's texture less that of the plain encoder's, at "
        "the asked rate where this is least.";
    rates.columns = {"texture codec", "mien's texture against plain", "all of mien against the others", "worst picture, dB"};
    rows.title = "Drawn views: every row";
    rows.columns = {"motion",         "texture",   "series", "asked kbit/s", "kbit/s in all",
                    "of them motion", "PSNR-Y dB", "SSIM",   "worst dB"};
    rows.details = true;
    std::map<std::string, std::map<std::string, std::vector<RatePoint>>> texture_alone, all;
    std::map<std::string, std::map<double, std::map<std::string, double>>> worst;  // by codec, asked rate, series
    for (const ViewRow& row : report.views) {
        if (row.clip != clip.key) continue;
        const bool ours = is_ours(row.geometry) && row.series == "mien";
        Table::Row line{{row.geometry, row.texture, row.series, figure(row.asked_kbps, 4)}, ours};
        if (row.failed.empty()) {
            line.cells.insert(line.cells.end(), {figure(row.kbps, 4), figure(row.geometry_kbps, 4), figure(row.psnr_y, 4),
                                                 figure(row.ssim, 4), figure(row.worst_psnr_y, 4)});
            if (is_ours(row.geometry)) {
                texture_alone[row.texture][row.series].push_back({row.kbps - row.geometry_kbps, row.psnr_y});
                worst[row.texture][row.asked_kbps][row.series] = row.worst_psnr_y;
            }
            if (ours || !is_ours(row.geometry)) all[row.texture][row.series].push_back({row.kbps, row.psnr_y});
        } else {
            line.cells.insert(line.cells.end(), {row.failed, "", "", "", ""});
        }
        rows.rows.push_back(std::move(line));
    }
    if (rows.empty()) return {};
    for (auto& [codec, series] : texture_alone) {
        double least = std::numeric_limits<double>::infinity();
        for (auto& [asked, of] : worst[codec])
            if (of.count("mien") && of.count("plain")) least = std::min(least, of["mien"] - of["plain"]);
        rates.rows.push_back({{codec, percent(bd_rate(series["plain"], series["mien"])),
                               percent(bd_rate(all[codec]["plain"], all[codec]["mien"])),
                               std::isfinite(least) ? fmt::format("{:+.2f}", least) : "-"}});
    }
    return {rates, rows};
}

}  // namespace mien::bench
