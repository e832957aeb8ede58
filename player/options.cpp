#include "player/options.hpp"

#include <charconv>

#include "io/output_guard.hpp"
#include "net/url.hpp"
#include "player/statistics.hpp"

namespace mien::player {

Result<void> check_outputs(const Options& options) {
    std::vector<std::filesystem::path> inputs = {options.compare};
    if (!net::looks_like_url(options.input)) inputs.push_back(options.input);
    auto checked = io::guard_outputs(inputs,
                                     {{"--output", options.output, {".png", ".mp4"}},
                                      {"--sheet", options.sheet, {".png"}},
                                      {"--stats-json", options.stats, {}, std::string(kStatisticsBegin)}},
                                     options.overwrite);
    if (!checked.ok() && checked.error().code == ErrorCode::unavailable) return Error{checked.error().code, checked.error().message + "; -y overwrites it"};
    return checked;
}

Result<double> parse_time(std::string_view text) {
    const Error wrong{ErrorCode::invalid, "a time is seconds, minutes:seconds or hours:minutes:seconds, as 90, 1:30 or 0:01:30.5"};
    double seconds = 0;
    for (int part = 0; part < 3; ++part) {
        const std::size_t colon = text.find(':');
        const std::string_view number = text.substr(0, colon);
        const bool last = colon == std::string_view::npos;
        double value = 0;
        const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value, std::chars_format::fixed);
        if (error != std::errc() || end != number.data() + number.size() || !(value >= 0) || value > 1e7) return wrong;
        if ((part > 0 && value >= 60) || (!last && number.find('.') != std::string_view::npos)) return wrong;
        seconds = 60 * seconds + value;
        if (last) return seconds;
        text.remove_prefix(colon + 1);
    }
    return wrong;
}

}  // namespace mien::player
