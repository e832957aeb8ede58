#pragma once

#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace mien::samples {

/// Where recordings from outside the repository lie, or empty.
inline std::filesystem::path recordings() {
    namespace fs = std::filesystem;
    if (const char* named = std::getenv("MIEN_DATA")) return named;
    const fs::path beside = fs::path(MIEN_SOURCE_DIR) / "../shared/data";
    return fs::exists(beside) ? beside : fs::path();
}

/// A new folder of its own, gone with its content at the end of the test.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "mien_samples_XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

private:
    std::filesystem::path path_;
};

}  // namespace mien::samples
