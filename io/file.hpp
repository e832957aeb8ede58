#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/hash.hpp"
#include "core/result.hpp"
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

/// Writes a file whole or not at all: bytes go to "<path>.part", which commit() renames. Every failure throws
/// EnvironmentError naming the path and the reason (no permission, disk full); nothing is left behind then.
class OutputFile {
public:
    explicit OutputFile(std::filesystem::path path);
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();

    void write(ByteView bytes);
    void write(std::string_view text);
    void commit();  ///< closes the file and gives it its name

private:
    std::filesystem::path path_, part_;
    FileHandle file_;
};

/// Writes `bytes` as the whole of `path`, by OutputFile.
void write_file(const std::filesystem::path& path, ByteView bytes);
void write_file(const std::filesystem::path& path, std::string_view text);

}  // namespace mien::io
