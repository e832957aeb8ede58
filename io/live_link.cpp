#include "io/live_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/fault_list.hpp"
#include "io/file.hpp"
#include "io/frame_times.hpp"
#include "io/limits.hpp"
#include "io/point_faults.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

constexpr std::string_view kAngles[] = {"headyaw",    "headpitch",   "headroll",    "lefteyeyaw",  "lefteyepitch",
                                        "lefteyeroll", "righteyeyaw", "righteyepitch", "righteyeroll"};
constexpr int kAngleCount = 9;
constexpr double kLongestGap = 10;  // seconds: longer ones are two takes in one file, or a wrong timecode

struct Timecode {
    std::int64_t second = 0;  ///< of the day
    double frame = 0;         ///< within the second
};

std::optional<Timecode> parse_timecode(std::string_view text) {
    const auto fields = split(text, ':');
    if (fields.size() != 4) return std::nullopt;
    const auto h = parse_integer(fields[0]), m = parse_integer(fields[1]), s = parse_integer(fields[2]);
    const auto frame = parse_double(fields[3]);
    if (!h || !m || !s || !frame || *h < 0 || *h > 23 || *m < 0 || *m > 59 || *s < 0 || *s > 59) return std::nullopt;
    if (!(*frame >= 0 && *frame < 240)) return std::nullopt;
    return Timecode{*h * 3600 + *m * 60 + *s, *frame};
}

/// Timecode frames per second. The app counts to 60; other sources count to their own rate, which shows once a whole second
/// has passed.
double timecode_rate(const std::vector<Timecode>& times) {
    double largest = 0;
    for (const Timecode& t : times) largest = std::max(largest, t.frame);
    const bool whole_second_seen = times.back().second - times.front().second >= 2;
    if (!whole_second_seen && largest < 60) return 60;
    for (const double rate : {24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 100.0, 120.0})
        if (largest < rate) return rate;
    return 240;
}

struct Row {
    Timecode time;
    std::size_t line = 0;
    std::vector<float> values;  ///< weights, then the nine angles; NaN: no finite number
};

struct Columns {
    std::vector<std::string> names;           ///< of the weights
    std::vector<std::size_t> weights;         ///< column of each
    std::optional<std::size_t> angles[kAngleCount];
    std::size_t count = 0;

    bool has_head() const { return angles[0] && angles[1] && angles[2]; }
    bool has_eyes() const { return angles[3] && angles[4] && angles[6] && angles[7]; }
};

Result<Columns> parse_columns(std::string_view line) {
    Columns columns;
    const auto fields = split(line, ',');
    columns.count = fields.size();
    if (fields.size() < 3 || lower_case(fields[0]) != "timecode")
        return Error{ErrorCode::bad_magic, "this is not a Live Link Face file: its first column is not Timecode"};
    for (std::size_t i = 1; i < fields.size(); ++i) {
        const std::string name = lower_case(fields[i]);
        if (name == "blendshapecount" || name.empty()) continue;
        const auto* angle = std::find(std::begin(kAngles), std::end(kAngles), name);
        if (angle != std::end(kAngles)) {
            columns.angles[angle - kAngles] = i;
        } else {
            columns.names.emplace_back(fields[i]);
            columns.weights.push_back(i);
        }
    }
    if (columns.weights.empty()) return Error{ErrorCode::invalid, "the Live Link Face file has no weights"};
    if (std::int64_t(columns.weights.size()) > kMaxWeights) return Error{ErrorCode::limit_exceeded, "too many weights"};
    return columns;
}

/// Those that have a timecode and all columns; `faults` gets the others.
Result<std::vector<Row>> parse_rows(Lines& lines, const Columns& columns, FaultList& faults) {
    std::vector<Row> rows;
    for (std::string_view line; lines.next(line);) {
        if (trimmed(line).empty()) continue;
        const auto fields = split(line, ',');
        if (fields.size() != columns.count) {
            faults.add(lines.number(), fmt::format("{} columns where the header has {}", fields.size(), columns.count));
            continue;
        }
        const auto time = parse_timecode(fields[0]);
        if (!time) {
            faults.add(lines.number(), fmt::format("\"{}\" is no timecode HH:MM:SS:FF.sss", fields[0].substr(0, 40)));
            continue;
        }
        Row row{*time, lines.number(), {}};
        const auto take = [&](std::size_t column) {
            const float value = static_cast<float>(parse_double(fields[column]).value_or(NAN));
            row.values.push_back(std::isfinite(value) ? value : NAN);
        };
        for (const std::size_t column : columns.weights) take(column);
        for (const auto& column : columns.angles) {
            if (column) take(*column);
            else row.values.push_back(0);
        }
        rows.push_back(std::move(row));
        if (std::int64_t(rows.size()) > kMaxFrames) return Error{ErrorCode::limit_exceeded, "too many frames"};
    }
    if (rows.empty() && faults.empty()) return Error{ErrorCode::invalid, "the Live Link Face file has no frames"};
    return rows;
}

/// Names the values that are no numbers by weight and frame; empty when all are.
std::string not_finite(const std::vector<Row>& rows, const Columns& columns, const std::vector<std::int64_t>& frame_of_row) {
    const std::vector<std::string> angle_names(std::begin(kAngles), std::end(kAngles));
    PointFaults weights("weight", "weights", &columns.names), angles("angle", "angles", &angle_names);
    std::size_t line = 0;
    for (std::size_t r = 0; r < rows.size(); ++r)
        for (std::size_t i = 0; i < rows[r].values.size(); ++i) {
            if (!std::isnan(rows[r].values[i])) continue;
            if (line == 0) line = rows[r].line;
            if (i < columns.names.size()) weights.add(frame_of_row[r], std::int64_t(i));
            else angles.add(frame_of_row[r], std::int64_t(i - columns.names.size()));
        }
    if (line == 0) return "";
    const bool both = !weights.empty() && !angles.empty();
    return fmt::format("line {}: not a finite number: {}{}{}", line, weights.text(), both ? "; " : "", angles.text());
}

}  // namespace

// The app's angles are those of a mirrored head: takes with EyeLook weights show that a positive yaw looks to the actor's
// right, a positive pitch down. Mirrored, turns about y and z change their sign.
RigidPose live_link_pose(const float* angles) {
    const Eigen::Quaternionf rotation = Eigen::AngleAxisf(-angles[0], Vec3::UnitY()) * Eigen::AngleAxisf(angles[1], Vec3::UnitX()) *
                                        Eigen::AngleAxisf(-angles[2], Vec3::UnitZ());
    return {rotation.normalized(), Vec3::Zero()};
}

Gaze live_link_gaze(const float* angles) {
    return {{-angles[6], -angles[3]}, {-angles[7], -angles[4]}};
}

void live_link_angles(const RigidPose& pose, float* angles) {
    const Eigen::Matrix3f r = pose.rotation.normalized().toRotationMatrix();
    angles[0] = -std::atan2(r(0, 2), r(2, 2));
    angles[1] = std::asin(std::clamp(-r(1, 2), -1.0f, 1.0f));
    angles[2] = -std::atan2(r(1, 0), r(1, 1));
}

void live_link_angles(const Gaze& gaze, float* angles) {
    angles[3] = -gaze.yaw[1], angles[4] = -gaze.pitch[1], angles[5] = 0;
    angles[6] = -gaze.yaw[0], angles[7] = -gaze.pitch[0], angles[8] = 0;
}

bool is_live_link(std::string_view text) {
    std::string_view line;
    return Lines(text.substr(0, 4096)).next(line) && lower_case(trimmed(line)).starts_with("timecode,");
}

Result<LiveLinkTake> parse_live_link(std::string_view text) {
    Lines lines(text);
    std::string_view line;
    if (!lines.next(line)) return Error{ErrorCode::invalid, "the file is empty"};
    MIEN_TRY(columns, parse_columns(line));
    FaultList faults;
    MIEN_TRY(rows, parse_rows(lines, columns, faults));
    if (rows.empty()) return faults.error();

    std::vector<Timecode> times;
    for (const Row& row : rows) times.push_back(row.time);
    const double rate = timecode_rate(times);

    // In timecode frames since the first row's midnight; half a day backwards is the next midnight.
    std::vector<double> ticks;
    double midnight = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (i > 0 && times[i - 1].second - times[i].second > 43200) midnight += 86400;
        ticks.push_back((midnight + double(times[i].second)) * rate + times[i].frame);
    }
    const auto numbered = number_frames(ticks, kLongestGap * rate);
    if (!numbered) {
        // The same places by their lines, which people can look up.
        for (std::size_t i = 1; i < ticks.size(); ++i)
            if (const double step = ticks[i] - ticks[i - 1]; !(step >= 0 && step <= kLongestGap * rate))
                faults.add(rows[i].line, fmt::format("the timecode jumps by {:.2f} s", step / rate));
        if (!faults.empty()) return faults.error();
        return Error{numbered.error().code, "the timecodes make no sense: " + numbered.error().message};
    }
    const std::vector<std::int64_t>& frame_of_row = numbered->frame_of_row;
    const std::string no_numbers = not_finite(rows, columns, frame_of_row);
    if (!no_numbers.empty() || !faults.empty()) return faults.error(no_numbers);
    LiveLinkTake take;
    take.frame_rate = usual_rate(rate / numbered->step).value_or(Rational{30, 1});
    for (std::size_t i = 1; i < frame_of_row.size(); ++i)
        if (frame_of_row[i] == frame_of_row[i - 1]) take.repeated.push_back(std::int64_t(i));
    const std::int64_t frames = numbered->frames();
    const auto count = std::int64_t(columns.weights.size());
    if (frames > std::int64_t(rows.size()) * 100 + 1000)
        return Error{ErrorCode::limit_exceeded, "the file has far more dropped frames than recorded ones"};

    take.rows = std::int64_t(rows.size());
    take.weights = WeightSequence(frames, count);
    take.weights.names = columns.names;
    std::vector<float> angles(std::size_t(frames) * kAngleCount);
    const auto fill = [&](std::int64_t frame, const Row& a, const Row& b, float share) {
        for (std::int64_t i = 0; i < count + kAngleCount; ++i) {
            float* to = i < count ? take.weights.frame(frame) + i : angles.data() + frame * kAngleCount + i - count;
            const auto k = std::size_t(i);
            *to = share == 0 ? a.values[k] : a.values[k] + share * (b.values[k] - a.values[k]);
        }
    };
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::int64_t from = frame_of_row[i];
        if (i > 0 && from == frame_of_row[i - 1]) continue;
        fill(from, rows[i], rows[i], 0);
        if (i == 0) continue;
        // The row before may have been a repeat; its first row holds the frame.
        const std::int64_t before = frame_of_row[i - 1];
        for (std::int64_t f = before + 1; f < from; ++f) {
            fill(f, rows[i - 1], rows[i], float(f - before) / float(from - before));
            take.dropped.push_back(f);
        }
    }
    for (std::int64_t f = 0; f < frames; ++f) {
        const float* a = angles.data() + f * kAngleCount;
        if (columns.has_head()) take.head_pose.push_back(live_link_pose(a));
        if (columns.has_eyes()) take.gaze.push_back(live_link_gaze(a));
    }
    return take;
}

Result<LiveLinkTake> read_live_link(const std::filesystem::path& path) {
    MIEN_TRY(text, read_text(path));
    auto take = parse_live_link(text);
    if (!take) return in_file(path, take.error());
    return take;
}

}  // namespace mien::io
