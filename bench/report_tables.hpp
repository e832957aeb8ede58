#pragma once

#include <string>
#include <vector>

#include "bench/report.hpp"

/// What the HTML page and the Markdown page show, the same figures in both.
namespace mien::bench {

struct Table {
    std::string title, note;
    std::vector<std::string> columns;
    struct Row {
        std::vector<std::string> cells;
        bool ours = false;
    };
    std::vector<Row> rows;
    bool details = false;  ///< every single row, for who wants to check
    bool empty() const { return rows.empty(); }
};

/// Whether a column holds words and not figures.
bool is_text(const Table& table, std::size_t column);

/// A codec as it is shown: with its library's version where the report holds several of them.
std::string shown_codec(const Report& report, const std::string& codec, const std::string& library);
bool is_ours(const std::string& codec);

/// One row a clip: ours beside the best of the others at the error asked in the middle.
Table headline_table(const Report& report);
std::vector<Table> geometry_tables(const Report& report, const ClipFacts& clip);
std::vector<Table> timing_tables(const Report& report, const ClipFacts& clip);
std::vector<Table> texture_tables(const Report& report, const ClipFacts& clip);
std::vector<Table> view_tables(const Report& report, const ClipFacts& clip);
Table codec_table(const Report& report);
Table machine_table(const Report& report);

std::string describe(const ClipFacts& clip);   ///< "11 248 vertices, 600 frames at 30 Hz, ..."
std::string figure(double value, int digits);  ///< `digits` significant digits, no exponent

}  // namespace mien::bench
