#include "player/options.hpp"

#include <charconv>

namespace mien::player {

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
