#include "core/unfinished.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/environment_error.hpp"

namespace mien {
namespace {

namespace fs = std::filesystem;

struct Registry {
    std::mutex mutex;
    std::set<fs::path> paths;
};
/// Never destroyed: a signal may come while the process ends by itself.
Registry& registry() {
    static Registry& registry = *new Registry;
    return registry;
}

bool starts_with(const fs::path& path, const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// Of "PROCESS" or "PROCESS-N" the process, if there is none such any more.
bool of_a_dead_process(std::string_view text) {
    long process = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), process);
    const bool number = error == std::errc() && (end == text.data() + text.size() || *end == '-');
    return number && process > 0 && process <= std::numeric_limits<pid_t>::max() && ::kill(pid_t(process), 0) != 0 && errno == ESRCH;
}

void clear_leftovers(const fs::path& folder, const std::string& prefix) {
    std::error_code error;
    std::vector<fs::path> dead;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (name.starts_with(prefix) && of_a_dead_process(std::string_view(name).substr(prefix.size()))) dead.push_back(at->path());
    }
    for (const fs::path& path : dead) fs::remove_all(path, error);
}

/// An empty file or folder that was not there before; 0 or an errno.
int create(const fs::path& path, Unfinished::Kind kind) {
    if (kind == Unfinished::Kind::folder) return ::mkdir(path.c_str(), 0777) == 0 ? 0 : errno;
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) return errno;
    ::close(fd);
    return 0;
}

}  // namespace

Unfinished::Unfinished(const fs::path& target, Kind kind) : target_(target) {
    const std::string prefix = fmt::format(".{}.part-", target.filename().string());
    // A relative name would be another file once somebody changes the working directory.
    std::error_code error;
    const fs::path folder = fs::absolute(target, error).parent_path();
    Registry& r = registry();
    const std::lock_guard lock(r.mutex);
    // A folder in the making holds nobody's leftovers, but perhaps thousands of files.
    bool nested = false;
    for (const fs::path& other : r.paths) nested = nested || starts_with(folder, other);
    if (!nested) clear_leftovers(folder, prefix);
    int reason = EEXIST;
    for (int n = 0; reason == EEXIST && n < 1000; ++n) {
        path_ = folder / fmt::format("{}{}{}", prefix, ::getpid(), n ? fmt::format("-{}", n) : "");
        reason = create(path_, kind);
    }
    if (reason != 0) cannot_write(target_, reason);
    r.paths.insert(path_);
}

Unfinished::~Unfinished() {
    if (finished_) return;
    Registry& r = registry();
    const std::lock_guard lock(r.mutex);
    r.paths.erase(path_);
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

std::error_code Unfinished::finish(bool replace) {
    Registry& r = registry();
    const std::lock_guard lock(r.mutex);
    const std::error_code error = rename_path(path_, target_, replace);
    if (!error) {
        r.paths.erase(path_);
        finished_ = true;
    }
    return error;
}

std::error_code rename_path(const fs::path& from, const fs::path& to, bool replace) {
    const auto outcome = [](int code) { return code == 0 ? std::error_code() : std::error_code(errno, std::generic_category()); };
    if (replace) return outcome(::rename(from.c_str(), to.c_str()));
    const std::error_code error = outcome(::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE));
    // Not every file system knows how; then two that finish within the same instant may still meet.
    if (error != std::errc::invalid_argument && error != std::errc::function_not_supported) return error;
    std::error_code ignored;
    if (fs::exists(fs::symlink_status(to, ignored))) return std::make_error_code(std::errc::file_exists);
    return outcome(::rename(from.c_str(), to.c_str()));
}

std::unique_lock<std::mutex> keep_unfinished() { return std::unique_lock(registry().mutex); }

void abandon_unfinished() {
    Registry& r = registry();
    r.mutex.lock();
    for (const fs::path& path : r.paths) {
        // Other threads may still be adding files to a folder.
        std::error_code error;
        for (int n = 0; n < 100; ++n) {
            fs::remove_all(path, error);
            if (!error) break;
        }
    }
}

void cannot_write(const fs::path& path, int reason) {
    const char* advice = reason == ENOSPC   ? "; free some space or write to another disk"
                         : reason == EACCES ? "; choose a folder you may write to"
                         : reason == ENOENT ? "; make the folder first"
                         : reason == EEXIST ? "; another process has written it meanwhile"
                                            : "";
    throw EnvironmentError(fmt::format("cannot write {}: {}{}", path.string(), std::strerror(reason), advice));
}

}  // namespace mien
