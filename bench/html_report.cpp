#include <fmt/format.h>

#include "bench/report_plots.hpp"
#include "bench/report_tables.hpp"

// One file that needs nothing else: no script, no font, no fetch.
namespace mien::bench {
namespace {

constexpr const char* kStyle = R"css(
:root { color-scheme: light dark; --page: #fbfaf8; --card: #ffffff; --ink: #1d1f23; --soft: #646a73; --line: #dfe1e4; --wash: #eef4fb;
  --c0: #0b66c3; --c1: #8a3fb8; --c2: #d2600a; --c3: #25803c; --c4: #8a6d1b; --c5: #b3365f; --c6: #6b7280; --c7: #12808a; }
@media (prefers-color-scheme: dark) { :root { --page: #14161a; --card: #1b1e23; --ink: #e7e9ec; --soft: #9aa2ad; --line: #31363e; --wash: #1d2b3a;
  --c0: #63b0ff; --c1: #c892f0; --c2: #ff9d57; --c3: #6fce87; --c4: #d9b95b; --c5: #f283a6; --c6: #a3abb6; --c7: #5fd0da; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "Noto Sans", sans-serif; }
main { max-width: 1100px; margin: 0 auto; padding: 32px 20px 80px; }
h1 { font-size: 28px; margin: 0 0 4px; letter-spacing: -0.01em; }
h2 { font-size: 21px; margin: 48px 0 4px; padding-top: 20px; border-top: 1px solid var(--line); }
h3 { font-size: 16px; margin: 28px 0 4px; }
p { margin: 4px 0 10px; color: var(--soft); max-width: 84ch; }
nav a { color: var(--c0); margin-right: 14px; text-decoration: none; }
nav a:hover { text-decoration: underline; }
figure { margin: 14px 0; padding: 14px; background: var(--card); border: 1px solid var(--line); border-radius: 10px; overflow-x: auto; }
svg.plot { display: block; width: 100%; min-width: 640px; height: auto; font: 12px system-ui, -apple-system, "Segoe UI", "Noto Sans", sans-serif; }
svg .grid { stroke: var(--line); fill: none; } svg .axis { stroke: var(--soft); fill: none; }
svg .tick, svg .label { fill: var(--soft); } svg .name { fill: var(--ink); font-size: 13px; } svg .strong .name { font-weight: 600; }
svg .line { fill: none; stroke: currentColor; stroke-width: 1.6; } svg .strong .line { stroke-width: 2.8; }
svg .m { fill: currentColor; stroke: var(--card); stroke-width: 1; }
svg:hover .series:not(:hover) { opacity: 0.35; }
.c0 { color: var(--c0); } .c1 { color: var(--c1); } .c2 { color: var(--c2); } .c3 { color: var(--c3); }
.c4 { color: var(--c4); } .c5 { color: var(--c5); } .c6 { color: var(--c6); } .c7 { color: var(--c7); }
.scroll { overflow-x: auto; background: var(--card); border: 1px solid var(--line); border-radius: 10px; margin: 8px 0 14px; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 12px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); }
th { font-weight: 600; color: var(--soft); } tr:last-child td { border-bottom: 0; }
th.t, td.t { text-align: left; }
table.wide td:last-child { white-space: normal; }
tr.ours td { background: var(--wash); } tr.ours td:first-child { font-weight: 600; }
details { margin: 12px 0; } summary { cursor: pointer; color: var(--c0); }
pre { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 12px 14px; overflow-x: auto; font-size: 13px; }
)css";

/// wide: the last column is long text that may wrap.
std::string html_table(const Table& table, bool wide = false) {
    if (table.empty()) return {};
    std::string out = fmt::format("<div class=\"scroll\"><table{}><thead><tr>", wide ? " class=\"wide\"" : "");
    const auto tag = [&](const char* name, std::size_t column, const std::string& text) {
        return fmt::format("<{0}{1}>{2}</{0}>", name, wide || is_text(table, column) ? " class=\"t\"" : "", escaped(text));
    };
    for (std::size_t i = 0; i < table.columns.size(); ++i) out += tag("th", i, table.columns[i]);
    out += "</tr></thead><tbody>\n";
    for (const Table::Row& row : table.rows) {
        out += row.ours ? "<tr class=\"ours\">" : "<tr>";
        for (std::size_t i = 0; i < row.cells.size(); ++i) out += tag("td", i, row.cells[i]);
        out += "</tr>\n";
    }
    out += "</tbody></table></div>\n";
    if (table.details)
        return "<details><summary>" + escaped(table.title) + "</summary>" +
               (table.note.empty() ? "" : "<p>" + escaped(table.note) + "</p>") + out + "</details>\n";
    return "<h3>" + escaped(table.title) + "</h3>\n" + (table.note.empty() ? "" : "<p>" + escaped(table.note) + "</p>\n") + out;
}

std::string figure_of(const Plot& plot) {
    const std::string svg = svg_plot(plot);
    return svg.empty() ? "" : "<figure>" + svg + "</figure>\n";
}

std::string all_of(const std::vector<Table>& tables) {
    std::string out;
    for (const Table& table : tables) out += html_table(table);
    return out;
}

}  // namespace

std::string to_html(const Report& report) {
    std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width, "
        "initial-scale=1\">\n<title>mien-bench</title><style>";
    page += kStyle;
    page += "</style></head><body><main>\n<h1>mien-bench</h1>\n";
    page += fmt::format(
        "<p>{}, {}, on {}. All figures are of bytes that were decoded and measured against the clip; nothing on this page is "
        "fetched from elsewhere.</p>\n<nav>",
        escaped(report.version), escaped(report.date), escaped(report.machine.processor));
    for (std::size_t i = 0; i < report.clips.size(); ++i)
        page += fmt::format("<a href=\"#clip{}\">{}</a>", i, escaped(report.clips[i].name));
    page += "<a href=\"#machine\">machine, codecs and commands</a></nav>\n";
    page += html_table(headline_table(report));
    for (std::size_t i = 0; i < report.clips.size(); ++i) {
        const ClipFacts& clip = report.clips[i];
        page += fmt::format("<h2 id=\"clip{}\">{}</h2>\n<p>{}</p>\n", i, escaped(clip.name), escaped(describe(clip)));
        page +=
            figure_of(motion_plot(report, clip)) + all_of(geometry_tables(report, clip)) + all_of(timing_tables(report, clip));
        page += figure_of(texture_plot(report, clip)) + all_of(texture_tables(report, clip));
        page += figure_of(view_plot(report, clip)) + all_of(view_tables(report, clip));
    }
    page += "<h2 id=\"machine\">Machine, codecs and commands</h2>\n" + html_table(machine_table(report), true) +
            html_table(codec_table(report), true);
    page += "<h3>Commands</h3>\n<pre>";
    for (const std::string& command : report.commands) page += escaped(command) + "\n";
    return page + "</pre>\n</main></body></html>\n";
}

}  // namespace mien::bench
