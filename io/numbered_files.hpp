#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace mien::io {

/// Files of one folder whose names differ only in their last number: frame.0001.obj, frame.0002.obj, ...
struct NumberedFiles {
    std::vector<std::filesystem::path> paths;  ///< by ascending number
    std::vector<std::int64_t> numbers;
    std::string pattern;                       ///< "frame.####.obj", for messages
};

/// All such sets in `folder` whose ending (lower case, with its dot) is one of `endings`, the largest first. A file without a
/// number makes a set of its own.
std::vector<NumberedFiles> find_numbered(const std::filesystem::path& folder, const std::vector<std::string>& endings);

/// The set a printf pattern ("texture/%04d.png") or a folder means. Errors: missing, when no file is there; mismatch naming the first
/// number that lacks its file.
Result<NumberedFiles> open_numbered(const std::filesystem::path& pattern, const std::vector<std::string>& endings);

/// Errors: mismatch naming the first number that lacks its file.
Result<void> check_no_gap(const NumberedFiles& files);

}  // namespace mien::io
