#include "io/numbered_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "io/fault_list.hpp"
#include "io/index_ranges.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

struct Split {
    std::string before, after;
    std::int64_t number = -1;  ///< -1: no number
    std::size_t digits = 0;
};

/// Cuts a file name at the last number of its stem.
Split split_name(const std::string& name, std::size_t stem) {
    std::size_t end = stem;
    while (end > 0 && !is_digit(name[end - 1])) --end;
    std::size_t begin = end;
    while (begin > 0 && is_digit(name[begin - 1]) && end - begin < 15) --begin;
    if (begin == end) return {name, "", -1, 0};
    return {name.substr(0, begin), name.substr(end), parse_integer(name.substr(begin, end - begin)).value_or(-1), end - begin};
}

/// Where a pattern has its number, begin and end: %d or %0Nd (never handed to printf), a run of #, or *.
std::optional<std::pair<std::size_t, std::size_t>> number_place(const std::string& name) {
    const std::size_t begin = name.find_first_of("%#*");
    if (begin == std::string::npos) return std::nullopt;
    std::size_t end = begin + 1;
    if (name[begin] == '#') {
        end = std::min(name.size(), name.find_first_not_of('#', begin));
    } else if (name[begin] == '%') {
        while (end < name.size() && is_digit(name[end])) ++end;
        if (end == name.size() || name[end++] != 'd') return std::nullopt;
    }
    return std::pair{begin, end};
}

}  // namespace

std::vector<NumberedFiles> find_numbered(const fs::path& folder, const std::vector<std::string>& endings) {
    std::map<std::pair<std::string, std::string>, std::vector<std::pair<std::int64_t, fs::path>>> sets;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const fs::path& path = at->path();
        const std::string name = path.filename().string();
        std::error_code ignored;
        if (name.empty() || name.front() == '.' || at->is_directory(ignored)) continue;
        if (std::find(endings.begin(), endings.end(), lower_case(path.extension().string())) == endings.end()) continue;
        const Split cut = split_name(name, path.stem().string().size());
        sets[{cut.before, cut.after}].emplace_back(cut.number, path);
    }
    std::vector<NumberedFiles> result;
    for (auto& [key, files] : sets) {
        std::sort(files.begin(), files.end());
        NumberedFiles set;
        set.pattern = files[0].first < 0 ? key.first : key.first + "####" + key.second;
        for (auto& [number, path] : files) {
            set.numbers.push_back(number);
            set.paths.push_back(std::move(path));
        }
        result.push_back(std::move(set));
    }
    std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.paths.size() > b.paths.size(); });
    return result;
}

Result<NumberedFiles> one_per_number(const NumberedFiles& files) {
    NumberedFiles set;
    set.pattern = files.pattern;
    IndexRanges missing;
    FaultList faults;
    for (std::size_t i = 0; i < files.numbers.size(); ++i) {
        const std::int64_t number = files.numbers[i];
        if (i > 0 && number == set.numbers.back()) {
            faults.add(fmt::format("{} and {} have the same number", set.paths.back().string(), files.paths[i].filename().string()));
            continue;
        }
        if (i > 0 && number != set.numbers.back() + 1) {
            missing.add(set.numbers.back() + 1, number - 1);
            const bool most_are_there = missing.count() <= std::int64_t(files.numbers.size());
            while (most_are_there && set.numbers.back() + 1 < number) {
                set.numbers.push_back(set.numbers.back() + 1);
                set.paths.push_back(fs::path(set.paths.back()));
            }
        }
        set.numbers.push_back(number);
        set.paths.push_back(files.paths[i]);
    }
    if (missing.empty() && faults.empty()) return set;
    Error fault = faults.error(missing.empty() ? "" : fmt::format("{} missing between {} and {}", missing.subject("number", "numbers"), files.paths.front().string(),
                                                                  files.paths.back().filename().string()));
    fault.code = ErrorCode::mismatch;
    if (missing.count() > std::int64_t(files.numbers.size())) return fault;
    set.fault = std::move(fault);
    return set;
}

bool names_many(const fs::path& path) {
    std::error_code ignored;
    return fs::is_directory(path, ignored) || (!fs::exists(path, ignored) && number_place(path.filename().string()));
}

Result<NumberedFiles> open_numbered(const fs::path& pattern, const std::vector<std::string>& endings) {
    std::error_code ignored;
    if (fs::is_directory(pattern, ignored)) {
        const auto sets = find_numbered(pattern, endings);
        if (sets.empty())
            return Error{ErrorCode::missing, fmt::format("the folder {} has no files ending in {}", pattern.string(), fmt::join(endings, ", "))};
        return one_per_number(sets[0]);
    }
    const std::string name = pattern.filename().string();
    const auto place = number_place(name);
    if (!place) return Error{ErrorCode::missing, fmt::format("there is no file {}", pattern.string())};
    const std::string before = name.substr(0, place->first), after = name.substr(place->second);
    for (const auto& set : find_numbered(pattern.parent_path(), endings)) {
        const std::string first = set.paths[0].filename().string();
        if (set.numbers[0] < 0 || !first.starts_with(before) || !first.ends_with(after)) continue;
        if (set.pattern != before + "####" + after) continue;
        return one_per_number(set);
    }
    return Error{ErrorCode::missing, fmt::format("no file matches {}", pattern.string())};
}

}  // namespace mien::io
