#pragma once

#include <filesystem>

#include "core/clip.hpp"
#include "core/result.hpp"

namespace mien::bench {

/// Vertex motion of the ICT head: the first `vertices` vertices of the neutral (cm) plus the sum over rows of
/// arkit_to_ict_map.csv of weight x expression delta, for rows first .. first + count - 1 of a Live Link CSV, at 30 Hz. No
/// head pose.
Result<Clip> ict_clip(const std::filesystem::path& folder, const std::filesystem::path& csv, std::int64_t first,
                      std::int64_t count, std::int64_t vertices);

}  // namespace mien::bench
