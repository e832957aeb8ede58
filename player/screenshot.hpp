#pragma once

#include <filesystem>

namespace mien::player {

/// Makes an empty file "mien-0001.png" (the first number that is free) in `folder` and names it: what is there already is
/// never written over, even when two players take pictures at once. Throws EnvironmentError.
std::filesystem::path claim_screenshot(const std::filesystem::path& folder);

}  // namespace mien::player
