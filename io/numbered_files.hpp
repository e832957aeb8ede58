#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace mien::io {

/// Files of one folder whose names differ only in their last number: frame.0001.obj, frame.0002.obj, ...
struct NumberedFiles {
    std::vector<std::filesystem::path> paths;  ///< by ascending number
    std::vector<std::int64_t> numbers;
    std::string pattern;                       ///< "frame.####.obj", for messages
    std::optional<Error> fault;                ///< what one_per_number() found
};

/// All such sets in `folder` whose ending (lower case, with its dot) is one of `endings`, the largest first. A file without a
/// number makes a set of its own.
std::vector<NumberedFiles> find_numbered(const std::filesystem::path& folder, const std::vector<std::string>& endings);

/// The set with one path for every number. Where a number lacks its file or has several, `fault` (mismatch) names all such, and so that all else
/// keeps its frame, the path before stands for a missing one and the first of several counts. Error: the fault, if more are missing than there are.
Result<NumberedFiles> one_per_number(const NumberedFiles& files);

/// A folder, or a pattern that no file has for its name.
bool names_many(const std::filesystem::path& path);

/// The set a pattern ("texture/%04d.png", "texture/####.png" or "texture/*.png") or a folder means, one path per number. Errors: missing, when no file is there; those of
/// one_per_number().
Result<NumberedFiles> open_numbered(const std::filesystem::path& pattern, const std::vector<std::string>& endings);

}  // namespace mien::io
