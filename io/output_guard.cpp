#include "io/output_guard.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <fstream>

namespace mien::io {
namespace {

namespace fs = std::filesystem;

/// Also through links, and for a file that is not there yet.
bool same_file(const fs::path& a, const fs::path& b) {
    std::error_code error;
    if (fs::equivalent(a, b, error) && !error) return true;
    const fs::path one = fs::weakly_canonical(a, error);
    return !error && one == fs::weakly_canonical(b, error) && !error;
}

/// Is one of the input's own files; what is new in its folder is not.
bool belongs_to(const fs::path& file, const fs::path& input) {
    std::error_code error;
    if (same_file(file, input)) return true;
    if (!fs::is_directory(input, error) || !fs::exists(file, error)) return false;
    const fs::path folder = fs::canonical(input, error), inside = fs::canonical(file, error);
    return !error && std::mismatch(folder.begin(), folder.end(), inside.begin(), inside.end()).first == folder.end();
}

bool begins_with(const fs::path& path, const std::string& wanted) {
    std::ifstream file(path, std::ios::binary);
    std::string seen;
    for (char c; seen.size() < wanted.size() && file.get(c);)
        if (!std::isspace(static_cast<unsigned char>(c))) seen += c;
    return seen == wanted;
}

Result<void> guard_existing(const PlannedOutput& output) {
    std::error_code error;
    const fs::file_status status = fs::status(output.path, error);
    if (!fs::exists(status)) return {};
    if (fs::is_directory(status)) return Error{ErrorCode::invalid, fmt::format("{}: '{}' is a folder", output.option, output.path.string())};
    if (!fs::is_regular_file(status) || fs::file_size(output.path, error) == 0) return {};
    if (!output.begins.empty() && begins_with(output.path, output.begins)) return {};
    return Error{ErrorCode::unavailable,
                 fmt::format("'{}' is there already{}", output.path.string(), output.begins.empty() ? "" : fmt::format(" and is no earlier {} of this program", output.option))};
}

}  // namespace

Result<void> guard_outputs(const std::vector<fs::path>& inputs, const std::vector<PlannedOutput>& outputs, bool overwrite) {
    for (const PlannedOutput& output : outputs) {
        if (output.path.empty()) continue;
        if (!output.endings.empty() && std::find(output.endings.begin(), output.endings.end(), output.path.extension()) == output.endings.end())
            return Error{ErrorCode::invalid, fmt::format("{} writes {}, not '{}'", output.option, fmt::join(output.endings, " or "), output.path.string())};
        for (const fs::path& input : inputs)
            if (!input.empty() && belongs_to(output.path, input))
                return Error{ErrorCode::mismatch, fmt::format("{} would write over what is read: '{}'", output.option, output.path.string())};
        for (const PlannedOutput* other = outputs.data(); other != &output; ++other)
            if (!other->path.empty() && same_file(other->path, output.path) && !fs::is_character_file(output.path))
                return Error{ErrorCode::invalid, fmt::format("{} and {} are the same file, '{}'", other->option, output.option, output.path.string())};
        if (!overwrite) MIEN_CHECK(guard_existing(output));
    }
    return {};
}

}  // namespace mien::io
