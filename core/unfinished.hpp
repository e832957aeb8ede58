#pragma once

#include <filesystem>
#include <mutex>
#include <system_error>

namespace mien {

/// A file or folder in the making, beside the one that it is to become: ".NAME.part-PROCESS", a name that nobody else has. It is
/// gone with this object, and when a signal ends the process (core/interruption.hpp), unless it got its name before. What killed
/// processes left of the same target is cleared away. Throws EnvironmentError where it cannot be made.
class Unfinished {
public:
    enum class Kind { file, folder };

    Unfinished(const std::filesystem::path& target, Kind kind);
    Unfinished(const Unfinished&) = delete;
    Unfinished& operator=(const Unfinished&) = delete;
    ~Unfinished();

    /// Where it is made: an empty file or folder at first.
    const std::filesystem::path& path() const { return path_; }
    const std::filesystem::path& target() const { return target_; }

    /// Gives it the target's name. Without `replace` never to something that is there: std::errc::file_exists.
    std::error_code finish(bool replace);

private:
    std::filesystem::path target_, path_;
    bool finished_ = false;
};

/// rename(2); without `replace` never to a name that is taken, by whoever it was meanwhile: std::errc::file_exists.
std::error_code rename_path(const std::filesystem::path& from, const std::filesystem::path& to, bool replace);

/// While it is held no signal removes anything: for steps that are whole or not done at all.
[[nodiscard]] std::unique_lock<std::mutex> keep_unfinished();

/// Removes all that is unfinished in this process. Whoever makes, names or gives up another one from then on waits for ever, so
/// that nobody reports what is being taken away: only for a process that is about to end.
void abandon_unfinished();

/// Throws EnvironmentError "cannot write PATH: REASON", and what to do about it; `reason` is an errno.
[[noreturn]] void cannot_write(const std::filesystem::path& path, int reason);

}  // namespace mien
