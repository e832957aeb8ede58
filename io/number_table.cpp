#include "io/number_table.hpp"

#include <fmt/format.h>

#include <limits>

#include "io/fault_list.hpp"
#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

constexpr std::int64_t kMaxColumns = 1 << 20;

char separator_of(std::string_view line) {
    for (const char separator : {'\t', ';', ','})
        if (line.find(separator) != std::string_view::npos) return separator;
    return ' ';
}

std::vector<std::string_view> fields_of(std::string_view line, char separator) {
    if (separator != ' ') return split(line, separator);
    std::vector<std::string_view> words;
    for (auto word = take_word(line); !word.empty(); word = take_word(line)) words.push_back(word);
    return words;
}

}  // namespace

Result<NumberTable> parse_number_table(std::string_view text) {
    NumberTable table;
    FaultList faults;
    char separator = 0;
    Lines lines(text);
    for (std::string_view line; lines.next(line);) {
        const std::string_view content = trimmed(line);
        if (content.empty() || content.front() == '#') continue;
        const bool first = separator == 0;
        if (first) separator = separator_of(content);
        // A tab at either end separates an empty field, so those lines keep their ends.
        auto fields = fields_of(separator == '\t' ? line : content, separator);
        if (first) {
            bool numbers = true;
            for (const auto field : fields) numbers = numbers && (field.empty() || parse_double(field));
            table.columns = std::int64_t(fields.size());
            if (table.columns > kMaxColumns) return Error{ErrorCode::limit_exceeded, "the table has too many columns"};
            if (!numbers) {
                table.names.assign(fields.begin(), fields.end());
                continue;
            }
        }
        while (std::int64_t(fields.size()) > table.columns && fields.back().empty()) fields.pop_back();
        if (std::int64_t(fields.size()) < table.columns) table.short_lines.add(std::int64_t(lines.number()));
        if (std::int64_t(fields.size()) > table.columns) {
            faults.add(lines.number(), fmt::format("{} columns where the first line has {}", fields.size(), table.columns));
            fields.resize(std::size_t(table.columns));
        }
        for (std::size_t c = 0; c < fields.size(); ++c) {
            const auto value = fields[c].empty() ? std::numeric_limits<double>::quiet_NaN() : parse_double(fields[c]);
            if (!value)
                faults.add(lines.number(), fmt::format("\"{}\" in column {} is not a number", fields[c].substr(0, 40), table.names.empty() ? std::to_string(c + 1) : table.names[c]));
            table.values.push_back(static_cast<float>(value.value_or(0)));
        }
        ++table.rows;
        table.values.resize(std::size_t(table.rows * table.columns), std::numeric_limits<float>::quiet_NaN());
        // Short lines stand for blanks, but a small file may not ask for a huge table.
        if (table.values.size() > 64 * text.size() + (1 << 20) || std::int64_t(table.values.size()) > kMaxValues / 8) return Error{ErrorCode::limit_exceeded, "the table is too large; use NPY"};
    }
    if (!faults.empty()) return faults.error();
    return table;
}

Result<NumberTable> read_number_table(const std::filesystem::path& path) {
    if (lower_case(path.extension().string()) == ".npy") {
        MIEN_TRY(array, read_npy(path));
        if (array.shape.size() != 1 && array.shape.size() != 2)
            return Error{ErrorCode::invalid, fmt::format("{} has shape {}; one or two dimensions are wanted", path.string(), array.shape_text())};
        // An array without values may still have a side of any length.
        if (array.values.empty()) return NumberTable{};
        return NumberTable{{}, array.shape[0], array.shape.size() == 2 ? array.shape[1] : 1, std::move(array.values), {}};
    }
    MIEN_TRY(text, read_text(path));
    auto table = parse_number_table(text);
    if (!table) return in_file(path, table.error());
    return table;
}

}  // namespace mien::io
