#include "net/url.hpp"

#include <fmt/format.h>

#include <charconv>

#include "protocol/limits.hpp"

namespace mien::net {

namespace {

constexpr std::string_view kScheme = "mien://";

Error bad_url(std::string_view text, std::string_view why) {
    return {ErrorCode::invalid, fmt::format("'{}' is no stream's address: {}", text, why)};
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/// False when a '%' is not followed by two digits.
bool percent_decode(std::string_view text, std::string& out) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            out += text[i];
            continue;
        }
        const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
        const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
        if (high < 0 || low < 0) return false;
        out += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return true;
}

}  // namespace

bool looks_like_url(std::string_view text) { return text.find("://") != std::string_view::npos; }

Result<Url> parse_url(std::string_view text) {
    if (!text.starts_with(kScheme)) return bad_url(text, "it does not start with mien://");
    std::string_view rest = text.substr(kScheme.size());
    Url url;
    const std::size_t slash = rest.find('/');
    std::string_view place = rest.substr(0, slash);
    if (slash != std::string_view::npos && !percent_decode(rest.substr(slash + 1), url.name))
        return bad_url(text, "a '%' is not followed by two hexadecimal digits");
    if (url.name.size() > protocol::kMaxName) return bad_url(text, "the name is too long");

    std::string_view port;
    if (place.starts_with('[')) {
        const std::size_t close = place.find(']');
        if (close == std::string_view::npos) return bad_url(text, "the '[' of the address is not closed");
        url.host = place.substr(1, close - 1);
        port = place.substr(close + 1);
        if (!port.empty() && port[0] != ':') return bad_url(text, "only a port may follow ']'");
    } else {
        const std::size_t colon = place.find(':');
        url.host = place.substr(0, colon);
        port = colon == std::string_view::npos ? std::string_view() : place.substr(colon);
    }
    if (url.host.empty()) return bad_url(text, "the host is missing");
    if (!port.empty()) {
        port.remove_prefix(1);
        unsigned number = 0;
        const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
        if (error != std::errc() || end != port.data() + port.size() || number == 0 || number > 65535)
            return bad_url(text, "the port is not a number between 1 and 65535");
        url.port = static_cast<std::uint16_t>(number);
    }
    return url;
}

std::string to_string(const Url& url) {
    std::string name;
    for (const char c : url.name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                           std::string_view("-._~").find(c) != std::string_view::npos;
        if (plain)
            name += c;
        else
            name += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    const bool bracketed = url.host.find(':') != std::string::npos;
    return fmt::format("mien://{}{}{}:{}{}{}", bracketed ? "[" : "", url.host, bracketed ? "]" : "", url.port,
                       name.empty() ? "" : "/", name);
}

}  // namespace mien::net
