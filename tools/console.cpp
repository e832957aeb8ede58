#include "tools/console.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/environment_error.hpp"

namespace mien::tools {
namespace {

using Clock = std::chrono::steady_clock;

struct Bar {
    std::mutex mutex;
    std::string what;
    Clock::time_point started, drawn;
    bool open = false;
};
Bar& bar() {
    static Bar bar;
    return bar;
}

void draw(Bar& b, std::int64_t done, std::int64_t total) {
    constexpr int kWidth = 30;
    const double seconds = std::chrono::duration<double>(Clock::now() - b.started).count();
    if (total <= 0) {
        fmt::print(stderr, "\r{:<28} {:>6.1f} s\033[K", b.what, seconds);
    } else {
        const double share = std::min(1.0, double(done) / double(total));
        const int full = int(share * kWidth);
        std::string left;
        if (done > 0 && done < total && seconds > 1) left = fmt::format("  {:.0f} s left", seconds / share * (1 - share));
        fmt::print(stderr, "\r{:<28} [{:#<{}}{:.<{}}] {:>3.0f} %{}\033[K", b.what, "", full, "", kWidth - full, share * 100, left);
    }
    std::fflush(stderr);
}

}  // namespace

Progress progress_bar(bool quiet) {
    if (quiet || !isatty(STDERR_FILENO)) return {};
    return [](std::string_view what, std::int64_t done, std::int64_t total) {
        Bar& b = bar();
        const std::lock_guard lock(b.mutex);
        const auto now = Clock::now();
        const bool fresh = b.what != what || !b.open;
        if (fresh) {
            if (b.open) std::fputc('\n', stderr);
            b.what = what;
            b.started = now;
            b.open = true;
        }
        if (!fresh && done < total && now - b.drawn < std::chrono::milliseconds(80)) return;
        b.drawn = now;
        draw(b, done, total);
    };
}

void end_progress() {
    Bar& b = bar();
    const std::lock_guard lock(b.mutex);
    if (b.open) std::fputc('\n', stderr);
    b.open = false;
}

void warn(const std::string& text) {
    end_progress();
    fmt::print(stderr, "mien: warning: {}\n", text);
}

int fail(const std::string& text) {
    end_progress();
    fmt::print(stderr, "mien: error: {}\n", text);
    return kFailed;
}

int misused(const std::string& text) {
    fail(text);
    return kMisused;
}

int guarded(const std::function<Result<int>()>& command, bool json) {
    std::string why;
    try {
        const Result<int> code = command();
        end_progress();
        if (code.ok()) return *code;
        why = code.error().message;
    } catch (const EnvironmentError& error) {
        why = error.what();
    } catch (const std::bad_alloc&) {
        why = "out of memory";
    } catch (const std::system_error& error) {
        why = error.what();   // fmt::print, of standard output
    } catch (const std::exception& error) {
        why = std::string("unexpected: ") + error.what();
    }
    // File names need not be UTF-8.
    if (json) fmt::print("{}\n", nlohmann::json{{"error", why}}.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    return fail(why);
}

std::string with_thousands(std::uint64_t n) {
    std::string digits = std::to_string(n);
    for (int at = int(digits.size()) - 3; at > 0; at -= 3) digits.insert(std::size_t(at), " ");
    return digits;
}

std::string human_bytes(std::uint64_t bytes) {
    if (bytes < 10'000) return fmt::format("{} B", bytes);
    if (bytes < 10'000'000) return fmt::format("{:.1f} kB", double(bytes) / 1e3);
    return fmt::format("{:.1f} MB", double(bytes) / 1e6);
}

std::string human_time(double seconds) {
    const int minutes = int(seconds / 60);
    return fmt::format("{}:{:04.1f}", minutes, seconds - 60 * minutes);
}

}  // namespace mien::tools
