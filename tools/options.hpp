#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

/// What options of several commands mean and refuse. Whatever a validator refuses is a mistake on the command line: kMisused.
namespace mien::tools {

/// "must be a number above 0"
CLI::Validator above_zero();
/// "must be a number, 0 or above"
CLI::Validator not_negative();
/// "must be a number from LOW to HIGH"
CLI::Validator number_from(double low, double high);
/// Errors of motion that may be asked for, mm or weights: finer ones drown in the rounding of single-precision coordinates.
CLI::Validator motion_error();
/// What parse_frame_rate() takes.
CLI::Validator frame_rate();

/// --threads
void add_threads(CLI::App& command, int& threads, const std::string& more = "");

/// Why long work must not end in a stream or model file `output`, if so: that is a folder; or something is there and is not to be
/// overwritten (no -y), is read by the same command, or is no such file, as a part of a clip.
Result<void> may_write(const std::filesystem::path& output, bool overwrite, const std::vector<std::filesystem::path>& inputs);

}  // namespace mien::tools
