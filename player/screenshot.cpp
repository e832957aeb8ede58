#include "player/screenshot.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/environment_error.hpp"

namespace mien::player {

std::filesystem::path claim_screenshot(const std::filesystem::path& folder) {
    for (int number = 1; number < 10000; ++number) {
        const std::filesystem::path path = folder / fmt::format("mien-{:04d}.png", number);
        if (std::FILE* file = std::fopen(path.c_str(), "wx")) {   // x: fails when it exists
            std::fclose(file);
            return path;
        }
        if (errno != EEXIST)
            throw EnvironmentError(fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
    }
    throw EnvironmentError(fmt::format("{} is full of screenshots", folder.string()));
}

}  // namespace mien::player
