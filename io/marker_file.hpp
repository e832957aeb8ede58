#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clip.hpp"
#include "core/hash.hpp"
#include "io/number_table.hpp"
#include "io/point_faults.hpp"

namespace mien::io {

/// Markers as a file has them: in the file's unit, missing ones as three NaNs.
struct MarkerTake {
    PointSequence points;
    std::vector<std::string> names;      ///< one per marker, or empty
    std::optional<Rational> frame_rate;  ///< where the file tells it
    std::optional<Unit> unit;            ///< where the file tells it
    std::vector<std::string> warnings;
    PointFaults partly_missing{"marker", "markers"};  ///< those that lacked one or two of their coordinates, and are missing now
};

/// One rule for every file: a marker of which any coordinate is missing (NaN) is missing in that frame. Notes them in `take`.
void settle_missing(MarkerTake& take);

/// A table with columns NAME_x, NAME_y, NAME_z (or NAME.x, "NAME x", NAME:x), `frame` and `time_s` (or `time`) before them if they are
/// there; or without such names, three columns per marker. Blanks are missing. Rows that frame or time leave out become
/// frames without markers.
Result<MarkerTake> parse_marker_table(const NumberTable& table);

/// Whether a table's header is one of markers: most of its columns are NAME_x, NAME_y or NAME_z. (Weights may have groups of such names
/// among them.)
bool names_markers(const NumberTable& table);

/// Motion Analysis TRC: rate, unit and marker names from the header; tab-separated, blanks are missing.
Result<MarkerTake> parse_trc(std::string_view text);

/// C3D point data, 16-bit or float, written on Intel or DEC machines; rate, unit and labels from the parameters. Points
/// with a negative residual are missing.
Result<MarkerTake> parse_c3d(ByteView bytes);

/// Any of these, or NPY [F, M, 3], by the name's ending.
Result<MarkerTake> read_markers(const std::filesystem::path& path);

}  // namespace mien::io
