#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace mien::io {

/// A file that a command is about to write.
struct PlannedOutput {
    std::string option;                ///< that names it, for the message
    std::filesystem::path path;        ///< empty: it was not asked for
    std::vector<std::string> endings;  ///< it may have, as ".png"; none: any
    /// How a file of its kind begins, spaces and line ends apart: such a one is replaced without asking, as reports that are made again and
    /// again are. Empty: none is.
    std::string begins = {};
};

/// Held before any work is done: outputs have the endings they must have, are no two the same file, are none of the `inputs` (files, or folders
/// with all that is in them, whatever links lead there), and replace nothing but an empty file or an older report of their kind unless
/// `overwrite`. What is no file (a pipe, /dev/stdout) has nothing to lose. Errors: `invalid` (ending, or two outputs in one), `mismatch` (an input),
/// `unavailable` (there already).
Result<void> guard_outputs(const std::vector<std::filesystem::path>& inputs, const std::vector<PlannedOutput>& outputs, bool overwrite);

}  // namespace mien::io
