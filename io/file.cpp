#include "io/file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace mien::io {
namespace {

namespace fs = std::filesystem;

template <class Container>
Result<Container> read_whole(const fs::path& path, std::uint64_t limit) {
    MIEN_TRY(file, open_to_read(path));
    Container content;
    // Grows as bytes arrive instead of trusting a stated size: pipes and special files have none.
    std::error_code ignored;
    const std::uint64_t stated = fs::file_size(path, ignored);
    if (!ignored && stated <= limit) content.reserve(stated);
    for (std::size_t size = 0;;) {
        const std::size_t step = 1 << 20;
        content.resize(size + step);
        const std::size_t got = std::fread(content.data() + size, 1, step, file.get());
        size += got;
        if (size > limit)
            return Error{ErrorCode::limit_exceeded, fmt::format("{} is larger than {} MB", path.string(), limit >> 20)};
        if (got < step) {
            if (std::ferror(file.get()))
                return Error{ErrorCode::unavailable, fmt::format("{} cannot be read: {}", path.string(), std::strerror(errno))};
            content.resize(size);
            return content;
        }
    }
}

}  // namespace

Result<FileHandle> open_to_read(const fs::path& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) return Error{ErrorCode::missing, fmt::format("there is no file {}", path.string())};
    if (fs::is_directory(status)) return Error{ErrorCode::unavailable, fmt::format("{} is a folder, not a file", path.string())};
    FileHandle file(std::fopen(path.c_str(), "rb"));
    if (!file) return Error{ErrorCode::unavailable, fmt::format("{} cannot be read: {}", path.string(), std::strerror(errno))};
    return file;
}

Result<Bytes> read_bytes(const fs::path& path, std::uint64_t limit) { return read_whole<Bytes>(path, limit); }
Result<std::string> read_text(const fs::path& path, std::uint64_t limit) { return read_whole<std::string>(path, limit); }

Error in_file(const fs::path& path, Error error) {
    error.message = path.string() + ": " + error.message;
    return error;
}

OutputFile::OutputFile(const fs::path& path, bool replace) : unfinished_(path, Unfinished::Kind::file), replace_(replace) {
    file_.reset(std::fopen(unfinished_.path().c_str(), "wb"));
    if (!file_) cannot_write(path, errno);
}

void OutputFile::write(ByteView bytes) {
    if (!bytes.empty() && std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) cannot_write(unfinished_.target(), errno);
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text))); }

void OutputFile::commit() {
    // A full disk may show only when buffers are flushed.
    if (std::fclose(file_.release()) != 0) cannot_write(unfinished_.target(), errno);
    if (const std::error_code error = unfinished_.finish(replace_)) cannot_write(unfinished_.target(), error.value());
}

void OutputFile::commit_to_disk() {
    // EINVAL: what cannot be synchronised, such as some network disks.
    if (std::fflush(file_.get()) != 0 || (::fsync(::fileno(file_.get())) != 0 && errno != EINVAL)) cannot_write(unfinished_.target(), errno);
    commit();
}

void write_file(const fs::path& path, ByteView bytes) {
    OutputFile file(path);
    file.write(bytes);
    file.commit();
}

void write_file(const fs::path& path, std::string_view text) { write_file(path, std::as_bytes(std::span(text))); }

}  // namespace mien::io
