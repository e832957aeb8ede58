#include "bench/report_tables.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>

namespace mien::bench {

std::string figure(double value, int digits) {
    if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
    if (value == 0 || !std::isfinite(value)) return value == 0 ? "0" : "-";
    const int whole = int(std::floor(std::log10(std::abs(value)))) + 1;
    return fmt::format("{:.{}f}", value, std::clamp(digits - whole, 0, 9));
}

bool is_text(const Table& table, std::size_t column) {
    if (column == 0) return true;
    const auto words = std::count_if(table.rows.begin(), table.rows.end(), [&](const Table::Row& row) {
        return column < row.cells.size() && !row.cells[column].empty() &&
               std::isalpha(static_cast<unsigned char>(row.cells[column].front()));
    });
    return 2 * words > std::int64_t(table.rows.size());
}

bool is_ours(const std::string& codec) {
    return codec.starts_with("mien");
}

std::string shown_codec(const Report& report, const std::string& codec, const std::string& library) {
    std::set<std::string> libraries;
    for (const GeometryRow& row : report.geometry)
        if (row.codec == codec) libraries.insert(row.library);
    return libraries.size() > 1 ? codec + " " + library.substr(library.rfind(' ') + 1) : codec;
}

std::string describe(const ClipFacts& clip) {
    std::string text =
        fmt::format("{} {}, {} frames at {} Hz", clip.points, clip.kind, clip.frames, figure(clip.frames_per_second, 4));
    if (clip.texture_width) text += fmt::format(", texture {} x {}", clip.texture_width, clip.texture_height);
    if (clip.connectivity_bytes)
        text += fmt::format("; connectivity and texture coordinates in {} bytes", clip.connectivity_bytes);
    if (clip.draco_sorted_bytes)
        text += fmt::format("; {} triangles alone in Draco: {} bytes with vertices and triangles in another order, {} in theirs",
                            clip.triangles, clip.draco_sorted_bytes, clip.draco_ordered_bytes);
    return text;
}

Table headline_table(const Report& report) {
    Table table;
    table.title = "At one error";
    table.note =
        "kbit/s at the same asked RMS error (mm; weights: weight units), the middle one of those measured. \"Best other\" is the "
        "smallest of all other codecs "
        "of that mode but the 1998 scheme, which has a column of its own.";
    table.columns = {"clip",      "RMS asked",  "mien-live",       "best other live",
                     "mien-file", "mien-whole", "best other file", "guenter98"};
    for (const ClipFacts& clip : report.clips) {
        std::set<double> asked;
        for (const GeometryRow& row : report.geometry)
            if (row.clip == clip.key && row.asked_rms > 0 && row.failed.empty()) asked.insert(row.asked_rms);
        if (asked.empty()) continue;
        const double middle = *std::next(asked.begin(), std::ptrdiff_t(asked.size() / 2));
        std::map<std::string, double> ours;
        const GeometryRow *live = nullptr, *file = nullptr;
        for (const GeometryRow& row : report.geometry) {
            if (row.clip != clip.key || !row.failed.empty() || (row.asked_rms > 0 && row.asked_rms != middle)) continue;
            if (is_ours(row.codec) || row.codec == "guenter98") ours[row.codec] = row.kbps;
            else if (const GeometryRow*& best = row.mode == "live" ? live : file; !best || row.kbps < best->kbps) best = &row;
        }
        const auto cell = [&](const char* codec) { return ours.count(codec) ? figure(ours[codec], 4) : "-"; };
        const auto other = [&](const GeometryRow* row) {
            return row ? fmt::format("{} {}", figure(row->kbps, 4), shown_codec(report, row->codec, row->library)) : "-";
        };
        table.rows.push_back({{clip.name, figure(middle, 3), cell("mien-live"), other(live), cell("mien-file"),
                               cell("mien-whole"), other(file), cell("guenter98")}});
    }
    return table;
}

std::vector<Table> timing_tables(const Report& report, const ClipFacts& clip) {
    std::vector<Table> tables;
    for (const auto& [set, title, note] :
         {std::tuple{"frame", "Decoding, a frame at a time",
                     "Microseconds a frame on one core, ending in float32 positions for all: median and quartiles of single "
                     "frames. All codecs of the table in one run, "
                     "in turn, a second of the clip each; the last column is the median over those turns of the time divided by "
                     "the first row's."},
          std::tuple{"group", "Decoding, a second at a time",
                     "The same run by whole turns of a second, divided by their frames: throughput. Codecs whose frames come out "
                     "only all together are left out."},
          std::tuple{"encode", "Encoding",
                     "Microseconds a frame on one core: whole encodings of the first seconds of the clip, all codecs in turn, "
                     "median and quartiles."}}) {
        // Every run is a table of its own: times of different runs do not compare. What only one of them measured is in its title.
        std::map<std::string, std::set<std::string>> runs_with;
        std::set<std::string> runs;
        for (const TimingRow& row : report.timing)
            if (row.clip == clip.key && row.set == set) runs.insert(row.run), runs_with[row.library].insert(row.run);
        std::vector<const TimingRow*> rows;
        const auto flush = [&] {
            if (rows.empty()) return;
            Table table;
            table.title = title;
            std::set<std::string> here;
            for (const TimingRow* row : rows)
                if (!is_ours(row->codec) && runs_with[row->library].size() < runs.size()) here.insert(row->library);
            if (!here.empty()) table.title += fmt::format(": {}", fmt::join(here, ", "));
            table.note = fmt::format("{} RMS error asked: {}; {} samples a codec.", note, figure(rows.front()->asked_rms, 3),
                                     rows.front()->samples);
            table.columns = {"codec", "library", "lower quartile", "median", "upper quartile", "ns per point", "times the first"};
            for (const TimingRow* row : rows)
                table.rows.push_back({{row->codec, row->library, figure(row->lower * 1e6, 3), figure(row->median * 1e6, 3),
                                       figure(row->upper * 1e6, 3), figure(row->ns_per_point, 3), figure(row->ratio, 3)},
                                      is_ours(row->codec)});
            tables.push_back(std::move(table));
            rows.clear();
        };
        for (const TimingRow& row : report.timing) {
            if (row.clip != clip.key || row.set != set) continue;
            if (!rows.empty() && row.run != rows.front()->run) flush();
            rows.push_back(&row);
        }
        flush();
    }
    return tables;
}

Table codec_table(const Report& report) {
    Table table;
    table.title = "Codecs";
    table.columns = {"codec", "library", "what it is"};
    std::map<std::string, std::set<std::string>> libraries;
    for (const GeometryRow& row : report.geometry) libraries[row.codec].insert(row.library);
    for (const auto& [name, what] : report.codecs) {
        std::string versions;
        for (const std::string& library : libraries[name]) versions += (versions.empty() ? "" : ", ") + library;
        table.rows.push_back({{name, versions, what}, is_ours(name)});
    }
    for (const auto& [name, why] : report.absent) table.rows.push_back({{name, "absent", why}});
    return table;
}

Table machine_table(const Report& report) {
    const Machine& m = report.machine;
    Table table;
    table.title = "Machine";
    table.columns = {"what", "figure"};
    table.rows = {{{"processor", fmt::format("{}, {} core{}", m.processor, m.cores, m.cores == 1 ? "" : "s")}},
                  {{"system", m.system}},
                  {{"compiler", m.compiler}},
                  {{"read bandwidth, one core", fmt::format("{} GB/s", figure(m.read_gbytes_per_s, 3))}},
                  {{"SGEMM (Eigen), one core", fmt::format("{} GFLOP/s", figure(m.sgemm_gflops, 3))}},
                  {{"program", report.version}},
                  {{"date", report.date}}};
    return table;
}

}  // namespace mien::bench
