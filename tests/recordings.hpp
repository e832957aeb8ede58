#pragma once

#include <cstdlib>
#include <filesystem>

namespace mien::tests {

/// Where recordings from outside the repository lie, or empty.
inline std::filesystem::path recordings() {
    namespace fs = std::filesystem;
    if (const char* named = std::getenv("MIEN_DATA")) return named;
    const fs::path beside = fs::path(MIEN_SOURCE_DIR) / "../shared/data";
    return fs::exists(beside) ? beside : fs::path();
}

}  // namespace mien::tests
