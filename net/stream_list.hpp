#pragma once

#include <chrono>
#include <vector>

#include "net/url.hpp"
#include "protocol/messages.hpp"

namespace mien::net {

/// What a server offers, by name. Blocks up to `timeout`.
Result<std::vector<protocol::StreamEntry>> list_streams(const Url& url,
                                                        std::chrono::milliseconds timeout = std::chrono::seconds(5));

}  // namespace mien::net
