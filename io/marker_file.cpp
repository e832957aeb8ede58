#include "io/marker_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "io/file.hpp"
#include "io/frame_times.hpp"
#include "io/limits.hpp"
#include "io/npy.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

/// "NoseTip_x" -> ("NoseTip", 0); -1 when the name ends in no axis.
std::pair<std::string, int> axis_of(const std::string& name) {
    if (name.size() < 3) return {name, -1};
    const std::string lower = lower_case(name);
    const char axis = lower.back(), before = lower[lower.size() - 2];
    if (axis < 'x' || axis > 'z' || (before != '_' && before != '.' && before != ' ' && before != ':')) return {name, -1};
    return {name.substr(0, name.size() - 2), axis - 'x'};
}

/// The markers' columns, three each.
Result<std::vector<std::array<std::int64_t, 3>>> named_columns(const NumberTable& table, std::vector<std::string>& names) {
    std::vector<std::array<std::int64_t, 3>> columns;
    std::map<std::string, std::size_t> known;
    for (std::size_t c = 0; c < table.names.size(); ++c) {
        const auto [name, axis] = axis_of(table.names[c]);
        if (axis < 0) continue;
        const auto [at, added] = known.try_emplace(name, names.size());
        if (added) {
            names.push_back(name);
            columns.push_back({-1, -1, -1});
        }
        std::int64_t& column = columns[at->second][std::size_t(axis)];
        if (column >= 0) return Error{ErrorCode::invalid, fmt::format("column {} is there twice", table.names[c])};
        column = std::int64_t(c);
    }
    for (std::size_t m = 0; m < columns.size(); ++m)
        for (const std::int64_t column : columns[m])
            if (column < 0) return Error{ErrorCode::invalid, fmt::format("marker {} lacks one of its columns _x, _y, _z", names[m])};
    return columns;
}

std::optional<std::int64_t> column_named(const NumberTable& table, std::initializer_list<std::string_view> names) {
    for (std::size_t c = 0; c < table.names.size(); ++c)
        for (const std::string_view name : names)
            if (lower_case(table.names[c]) == name) return std::int64_t(c);
    return std::nullopt;
}

std::vector<double> column_values(const NumberTable& table, std::int64_t column) {
    std::vector<double> values;
    for (std::int64_t r = 0; r < table.rows; ++r) values.push_back(table.at(r, column));
    return values;
}

/// Rounds a rate found from printed times (0.016667) as number_frames cannot: over the whole recording.
double whole_step(const std::vector<double>& times, const FrameTimes& numbered) {
    return numbered.frames() > 1 ? (times.back() - times.front()) / double(numbered.frames() - 1) : 0;
}

}  // namespace

bool names_markers(const NumberTable& table) {
    const auto axes = std::count_if(table.names.begin(), table.names.end(), [](const std::string& name) { return axis_of(name).second >= 0; });
    return 2 * axes > std::ptrdiff_t(table.names.size());
}

Result<MarkerTake> parse_marker_table(const NumberTable& table) {
    MarkerTake take;
    // Blanks say that a marker is missing; a line that ends early may have been cut.
    if (const IndexRanges& lines = table.short_lines; !lines.empty())
        take.warnings.push_back(fmt::format("{} {} fewer columns than the first, and the markers that they lack are missing", lines.text("line", "lines"),
                                            lines.count() == 1 ? "has" : "have"));
    std::vector<std::array<std::int64_t, 3>> columns;
    const auto frame = column_named(table, {"frame", "frame#", "frames"});
    const auto time = column_named(table, {"time_s", "time", "seconds", "t"});
    MIEN_TRY(named, named_columns(table, take.names));
    columns = named;
    if (!columns.empty()) {
        std::vector<std::string> others;
        for (std::size_t c = 0; c < table.names.size(); ++c) {
            if (std::int64_t(c) == frame || std::int64_t(c) == time || axis_of(table.names[c]).second >= 0) continue;
            others.push_back(table.names[c].substr(0, 40));
        }
        if (!others.empty()) take.warnings.push_back(fmt::format("{} columns are no marker's and are not used: {}", others.size(), fmt::join(others, ", ")));
    } else {
        std::vector<std::int64_t> plain;
        for (std::int64_t c = 0; c < table.columns; ++c)
            if (c != frame && c != time) plain.push_back(c);
        if (plain.empty() || plain.size() % 3 != 0)
            return Error{ErrorCode::invalid, fmt::format("{} columns are not three per marker; name them MARKER_x, MARKER_y, MARKER_z", plain.size())};
        for (std::size_t i = 0; i < plain.size(); i += 3) columns.push_back({plain[i], plain[i + 1], plain[i + 2]});
    }
    if (std::int64_t(columns.size()) > kMaxMarkers) return Error{ErrorCode::limit_exceeded, "too many markers"};
    if (table.rows == 0) return Error{ErrorCode::invalid, "the file has no frames"};

    FrameTimes numbered;
    for (std::int64_t r = 0; r < table.rows; ++r) numbered.frame_of_row.push_back(r);
    if (time) {
        const auto times = column_values(table, *time);
        const auto by_time = number_frames(times, 3600);
        if (!by_time) return Error{by_time.error().code, fmt::format("column {}: {}", table.names[std::size_t(*time)], by_time.error().message)};
        numbered = *by_time;
        if (table.rows > 1) take.frame_rate = usual_rate(1 / whole_step(times, numbered));
    }
    if (frame) {
        const auto by_frame = number_frames(column_values(table, *frame), 1e6);
        if (!by_frame) return Error{by_frame.error().code, fmt::format("column {}: {}", table.names[std::size_t(*frame)], by_frame.error().message)};
        numbered = *by_frame;
    }
    const std::int64_t frames = numbered.frames();
    if (frames > table.rows * 100 + 1000)
        return Error{ErrorCode::limit_exceeded, fmt::format("{} rows stand for {} frames", table.rows, frames)};
    if (frames != table.rows)
        take.warnings.push_back(fmt::format("{} rows are {} frames by their {}; frames without a row have no markers", table.rows, frames, frame ? "numbers" : "times"));

    take.points = PointSequence(frames, std::int64_t(columns.size()));
    std::fill(take.points.xyz.begin(), take.points.xyz.end(), kMissing);
    for (std::int64_t r = 0; r < table.rows; ++r) {
        auto points = take.points.frame(numbered.frame_of_row[std::size_t(r)]);
        for (std::size_t m = 0; m < columns.size(); ++m) {
            points.row(Eigen::Index(m)) << table.at(r, columns[m][0]), table.at(r, columns[m][1]), table.at(r, columns[m][2]);
        }
    }
    settle_missing(take);
    return take;
}

void settle_missing(MarkerTake& take) {
    for (std::int64_t f = 0; f < take.points.frames; ++f) {
        auto points = take.points.frame(f);
        for (std::int64_t m = 0; m < take.points.points; ++m) {
            auto point = points.row(m);
            const Eigen::Index lacking = point.array().isNaN().count();
            if (lacking == 0) continue;
            if (lacking < 3) take.partly_missing.add(f, m);
            point.setConstant(kMissing);
        }
    }
}

Result<MarkerTake> read_markers(const std::filesystem::path& path) {
    const std::string ending = lower_case(path.extension().string());
    if (ending == ".npy") {
        MIEN_TRY(array, read_npy(path));
        if (array.shape.size() != 3 || array.shape[2] != 3)
            return Error{ErrorCode::invalid, fmt::format("{} has shape {}; [frames, markers, 3] is wanted", path.string(), array.shape_text())};
        MarkerTake take;
        take.points.frames = array.shape[0];
        take.points.points = array.shape[1];
        take.points.xyz = std::move(array.values);
        settle_missing(take);
        return take;
    }
    const auto named = [&](Result<MarkerTake> take) -> Result<MarkerTake> {
        if (!take) return in_file(path, take.error());
        return take;
    };
    if (ending == ".c3d") {
        MIEN_TRY(bytes, read_bytes(path));
        return named(parse_c3d(bytes));
    }
    if (ending == ".trc") {
        MIEN_TRY(text, read_text(path));
        return named(parse_trc(text));
    }
    if (ending != ".csv" && ending != ".txt" && ending != ".tsv")
        return Error{ErrorCode::invalid, fmt::format("{}: markers come as .npy, .csv, .trc or .c3d", path.string())};
    MIEN_TRY(table, read_number_table(path));
    return named(parse_marker_table(table));
}

}  // namespace mien::io
