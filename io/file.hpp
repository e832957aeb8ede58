#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/hash.hpp"
#include "core/result.hpp"
#include "core/unfinished.hpp"
#include "io/limits.hpp"

namespace mien::io {

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, FileCloser>;

/// Opens a file for reading. Errors: missing (there is none), unavailable (it cannot be read), both naming the path.
Result<FileHandle> open_to_read(const std::filesystem::path& path);

/// A whole file. Errors as open_to_read; limit_exceeded above `limit` bytes.
Result<Bytes> read_bytes(const std::filesystem::path& path, std::uint64_t limit = kMaxFileBytes);
Result<std::string> read_text(const std::filesystem::path& path, std::uint64_t limit = kMaxFileBytes);

/// The same error, its message led by the file's path.
Error in_file(const std::filesystem::path& path, Error error);

/// Writes a file whole or not at all: bytes go to a file beside it (core/unfinished.hpp), which commit() renames. Every failure
/// throws EnvironmentError naming the path and the reason (no permission, disk full); nothing is left behind then.
class OutputFile {
public:
    /// Without `replace`, commit() fails when a file of that name has come meanwhile.
    explicit OutputFile(const std::filesystem::path& path, bool replace = true);

    void write(ByteView bytes);
    void write(std::string_view text);
    void commit();  ///< closes the file and gives it its name
    /// The same for the one result of long work, which shall survive a power cut too.
    void commit_to_disk();

private:
    Unfinished unfinished_;
    FileHandle file_;
    bool replace_;
};

/// Writes `bytes` as the whole of `path`, by OutputFile.
void write_file(const std::filesystem::path& path, ByteView bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace mien::io
