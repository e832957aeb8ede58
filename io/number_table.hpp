#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "io/index_ranges.hpp"

namespace mien::io {

/// Rows of numbers from a text file.
struct NumberTable {
    std::vector<std::string> names;  ///< of the columns, or empty when the file has no header
    std::int64_t rows = 0, columns = 0;
    std::vector<float> values;       ///< rows * columns; a blank is NaN
    IndexRanges short_lines;         ///< numbers of those with fewer columns than the first one

    float at(std::int64_t row, std::int64_t column) const { return values[std::size_t(row * columns + column)]; }
};

/// Text columns between commas, semicolons, tabs or spaces (told by the first line); a first line that is not all numbers is
/// the header; lines that begin with '#' are skipped. Rows may be shorter than the first (the rest is blank), never longer.
/// Errors: invalid naming line and column of all that is no number.
Result<NumberTable> parse_number_table(std::string_view text);

/// The same from an NPY file of one or two dimensions, or from text, by the name's ending. A 1-D array is one column.
Result<NumberTable> read_number_table(const std::filesystem::path& path);

}  // namespace mien::io
