#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

namespace mien {

/// How long work reports itself: what it is doing, and done of total (total 0: unknown). Called from one thread at a
/// time; an empty function means nobody wants to know.
using Progress = std::function<void(std::string_view what, std::int64_t done, std::int64_t total)>;

}  // namespace mien
