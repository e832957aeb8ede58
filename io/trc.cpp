#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "io/fault_list.hpp"
#include "io/frame_times.hpp"
#include "io/limits.hpp"
#include "io/marker_file.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

std::optional<Unit> unit_named(std::string_view text) {
    const std::string name = lower_case(text);
    for (const Unit unit : {Unit::mm, Unit::cm, Unit::m})
        if (name == name_of(unit)) return unit;
    return std::nullopt;
}

}  // namespace

Result<MarkerTake> parse_trc(std::string_view text) {
    Lines lines(text);
    std::string_view file_type, keys, values, names, axes;
    if (!lines.next(file_type) || !trimmed(file_type).starts_with("PathFileType"))
        return Error{ErrorCode::bad_magic, "this is not a TRC file: it does not begin with PathFileType"};
    if (!lines.next(keys) || !lines.next(values) || !lines.next(names) || !lines.next(axes))
        return Error{ErrorCode::truncated, "the TRC header ends early"};

    MarkerTake take;
    std::int64_t stated_frames = -1, stated_markers = -1;
    const auto key_fields = split(keys, '\t'), value_fields = split(values, '\t');
    for (std::size_t i = 0; i < std::min(key_fields.size(), value_fields.size()); ++i) {
        const std::string key = lower_case(key_fields[i]);
        if (key == "datarate") {
            const auto rate = parse_double(value_fields[i]);
            if (rate) take.frame_rate = usual_rate(*rate);
        } else if (key == "numframes") {
            stated_frames = parse_integer(value_fields[i]).value_or(-1);
        } else if (key == "nummarkers") {
            stated_markers = parse_integer(value_fields[i]).value_or(-1);
        } else if (key == "units") {
            take.unit = unit_named(value_fields[i]);
        }
    }
    // "Frame#", "Time", then each name over its three columns.
    const auto name_fields = split(names, '\t');
    for (std::size_t i = 2; i < name_fields.size(); ++i)
        if (!name_fields[i].empty()) take.names.emplace_back(name_fields[i]);
    const std::int64_t markers = stated_markers >= 0 ? stated_markers : std::int64_t(take.names.size());
    if (markers > kMaxMarkers) return Error{ErrorCode::limit_exceeded, fmt::format("{} markers are too many", markers)};
    if (markers == 0) return Error{ErrorCode::invalid, "the TRC file has no markers"};
    if (std::int64_t(take.names.size()) != markers) {
        take.warnings.push_back(fmt::format("the TRC header names {} of {} markers", take.names.size(), markers));
        take.names.clear();
    }

    FaultList faults;
    std::vector<float>& xyz = take.points.xyz;
    for (std::string_view line; lines.next(line);) {
        if (trimmed(line).empty()) continue;
        const auto fields = split(line, '\t');
        const auto refuse = [&](std::string_view what) { return Error{ErrorCode::limit_exceeded, fmt::format("line {}: {}", lines.number(), what)}; };
        if (!parse_double(fields[0])) faults.add(lines.number(), fmt::format("\"{}\" is not a frame number", fields[0].substr(0, 40)));
        const auto beyond = fields.begin() + std::ptrdiff_t(std::min(fields.size(), std::size_t(markers) * 3 + 2));
        if (std::any_of(beyond, fields.end(), [](std::string_view field) { return !field.empty(); })) faults.add(lines.number(), fmt::format("more than {} markers", markers));
        // Short lines stand for missing markers, but a small file may not ask for a huge table.
        if (xyz.size() > 64 * text.size() + (1 << 20)) return refuse("far fewer columns than markers");
        for (std::int64_t m = 0; m < markers; ++m) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::size_t c = std::size_t(m) * 3 + 2 + axis;
                const bool blank = c >= fields.size() || fields[c].empty();
                const auto value = blank ? std::numeric_limits<double>::quiet_NaN() : parse_double(fields[c]);
                if (!value) faults.add(lines.number(), fmt::format("\"{}\" in column {} is not a number", fields[c].substr(0, 40), c + 1));
                xyz.push_back(static_cast<float>(value.value_or(0)));
            }
        }
        if (++take.points.frames > kMaxFrames) return refuse("too many frames");
    }
    if (!faults.empty()) return faults.error();
    take.points.points = markers;
    if (take.points.frames == 0) return Error{ErrorCode::invalid, "the TRC file has no frames"};
    if (stated_frames >= 0 && stated_frames != take.points.frames)
        take.warnings.push_back(fmt::format("the TRC header says {} frames, the file has {}", stated_frames, take.points.frames));
    settle_missing(take);
    return take;
}

}  // namespace mien::io
