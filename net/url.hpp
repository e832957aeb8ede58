#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.hpp"

namespace mien::net {

inline constexpr std::uint16_t kDefaultPort = 7777;

/// mien://host[:port][/name]. IPv6 hosts stand in brackets. The name is percent-decoded.
struct Url {
    std::string host;
    std::uint16_t port = kDefaultPort;
    std::string name;  ///< of the stream; empty: the server itself

    bool operator==(const Url&) const = default;
};

/// Whether `text` is meant as a URL at all (it has "://"), not as a file name.
bool looks_like_url(std::string_view text);
Result<Url> parse_url(std::string_view text);
std::string to_string(const Url& url);

}  // namespace mien::net
