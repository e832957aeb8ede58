#include "net/stored_stream.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace mien::net {

namespace {

class File {
public:
    explicit File(int descriptor) : descriptor_(descriptor) {}
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() {
        if (descriptor_ >= 0) ::close(descriptor_);
    }
    int get() const { return descriptor_; }

private:
    int descriptor_;
};

Result<std::size_t> read_at(int descriptor, std::uint64_t offset, std::span<std::byte> into) {
    std::size_t done = 0;
    while (done < into.size()) {
        const ssize_t got = ::pread(descriptor, into.data() + done, into.size() - done, off_t(offset + done));
        if (got == 0) break;
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return Error{ErrorCode::unavailable, fmt::format("reading the file failed: {}", std::strerror(errno))};
        done += std::size_t(got);
    }
    return done;
}

}  // namespace

Result<protocol::StreamFileReader> open_stored_stream(const std::filesystem::path& path) {
    const auto say = [&](ErrorCode code, const std::string& why) { return Error{code, path.string() + ": " + why}; };
    // O_NONBLOCK: a pipe under this name must not hold us up before we see that it is one.
    const auto file = std::make_shared<File>(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat status {};
    if (file->get() < 0 || ::fstat(file->get(), &status) != 0) return say(ErrorCode::unavailable, std::strerror(errno));
    if (!S_ISREG(status.st_mode)) return say(ErrorCode::unavailable, "this is not a file");
    auto reader = protocol::StreamFileReader::open(
        [file](std::uint64_t offset, std::span<std::byte> into) { return read_at(file->get(), offset, into); },
        std::uint64_t(status.st_size));
    if (!reader) return say(reader.error().code, reader.error().message);
    return reader;
}

}  // namespace mien::net
