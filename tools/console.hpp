#pragma once

#include <functional>
#include <string>

#include "core/progress.hpp"
#include "core/result.hpp"

/// How `mien` speaks to a person at a terminal: results on standard output, everything else on standard error.
namespace mien::tools {

inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;      ///< the input or the environment; said on standard error
inline constexpr int kMisused = 2;     ///< the command line

/// A progress bar on standard error; silent when that is no terminal or `quiet`.
Progress progress_bar(bool quiet);
/// Ends the bar's line.
void end_progress();

void warn(const std::string& text);
/// "mien: error: TEXT"; returns kFailed.
int fail(const std::string& text);

/// The same for what only the command line can put right; returns kMisused.
int misused(const std::string& text);

/// Runs a command; an error and whatever it throws become a message and kFailed. With `json`, standard output then holds
/// {"error": "TEXT"}, so that whoever asked for JSON always gets some.
int guarded(const std::function<Result<int>()>& command, bool json = false);

std::string with_thousands(std::uint64_t n);   ///< "1 234 567"
std::string human_bytes(std::uint64_t bytes);  ///< "1.2 MB"
std::string human_time(double seconds);        ///< "1:02.5"

}  // namespace mien::tools
