#include "tools/options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "core/frame_rate.hpp"
#include "io/file.hpp"
#include "protocol/bodies.hpp"

namespace mien::tools {
namespace {

namespace fs = std::filesystem;

/// A validator without a word of its own in --help.
template <class Takes>
CLI::Validator validator(Takes takes, std::string complaint) {
    return CLI::Validator([=](std::string& text) { return takes(text) ? std::string() : complaint; }, "", "");
}

std::optional<double> number(const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
    return value;
}

/// Streams and models begin with a message whose header is a few bytes.
bool is_ours(const fs::path& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return false;
    if (fs::file_size(path, error) == 0) return true;
    const auto file = io::open_to_read(path);
    char begin[16] = {};
    if (!file || std::fread(begin, 1, sizeof begin, file->get()) == 0) return false;
    return std::string_view(begin, sizeof begin).find(protocol::kMagic) != std::string_view::npos;
}

}  // namespace

CLI::Validator above_zero() {
    return validator([](const std::string& text) { return number(text).value_or(0) > 0; }, "must be a number above 0");
}

CLI::Validator not_negative() {
    return validator([](const std::string& text) { return number(text).value_or(-1) >= 0; }, "must be a number, 0 or above");
}

CLI::Validator number_from(double low, double high) {
    const auto within = [=](const std::string& text) {
        const auto value = number(text);
        return value && *value >= low && *value <= high;
    };
    return validator(within, fmt::format("must be a number from {} to {}", low, high));
}

CLI::Validator motion_error() { return number_from(0.0001, 1000); }

CLI::Validator frame_rate() {
    const auto complaint = [](const std::string& text) {
        const auto rate = parse_frame_rate(text);
        return rate ? std::string() : rate.error().message;
    };
    return CLI::Validator(complaint, "", "");
}

void add_threads(CLI::App& command, int& threads, const std::string& more) {
    command.add_option("--threads", threads, "Threads (default: all cores)" + more)->check(CLI::Range(1, 1024));
}

Result<void> may_write(const fs::path& output, bool overwrite, const std::vector<fs::path>& inputs) {
    std::error_code error;
    const auto refuse = [&](const std::string& why) { return Error{ErrorCode::invalid, "'" + output.string() + "' " + why}; };
    if (fs::is_directory(output, error)) return refuse("is a folder; name a file in it");
    if (!fs::exists(output, error)) return {};
    if (!overwrite) return refuse("is there already; -y overwrites it");
    for (const fs::path& input : inputs)
        if (fs::equivalent(input, output, error)) return refuse("is read to make what would overwrite it; name another file");
    if (!is_ours(output)) return refuse("is no stream or model file, so it is not overwritten; name another file, or remove it first");
    return {};
}

}  // namespace mien::tools
