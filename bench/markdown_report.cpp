#include <fmt/format.h>

#include "bench/report_tables.hpp"

namespace mien::bench {
namespace {

std::string markdown_table(const Table& table, const char* heading) {
    if (table.empty() || table.details) return {};
    std::string out = std::string(heading) + " " + table.title + "\n\n";
    if (!table.note.empty()) out += table.note + "\n\n";
    for (const std::string& column : table.columns) out += "| " + column + " ";
    out += "|\n";
    for (std::size_t i = 0; i < table.columns.size(); ++i) out += is_text(table, i) ? "| --- " : "| ---: ";
    out += "|\n";
    for (const Table::Row& row : table.rows) {
        for (std::size_t i = 0; i < row.cells.size(); ++i)
            out += i == 0 && row.ours ? "| **" + row.cells[i] + "** " : "| " + row.cells[i] + " ";
        out += "|\n";
    }
    return out + "\n";
}

}  // namespace

std::string to_markdown(const Report& report) {
    std::string page = markdown_table(headline_table(report), "##");
    for (const ClipFacts& clip : report.clips) {
        page += fmt::format("## {}\n\n{}.\n\n", clip.name, describe(clip));
        for (const auto& tables : {geometry_tables(report, clip), timing_tables(report, clip), texture_tables(report, clip),
                                   view_tables(report, clip)})
            for (const Table& table : tables) page += markdown_table(table, "###");
    }
    page += markdown_table(machine_table(report), "##") + markdown_table(codec_table(report), "##");
    page += "## Commands\n\n```sh\n";
    for (const std::string& command : report.commands) page += command + "\n";
    return page + "```\n";
}

}  // namespace mien::bench
