#include "net/blob_cache.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "core/environment_error.hpp"
#include "protocol/limits.hpp"

namespace mien::net {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kAside = ".part";
constexpr auto kStaleAside = std::chrono::hours(1);  // nobody writes one blob for so long: its process died

bool write_whole(const fs::path& path, ByteView bytes) {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    out.close();
    return bool(out);
}

}  // namespace

fs::path DiskBlobCache::default_folder() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache == '/') return fs::path(cache) / "mien" / "blobs";
    if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "mien" / "blobs";
    return fs::temp_directory_path() / fmt::format("mien-{}", ::getuid()) / "blobs";
}

DiskBlobCache::DiskBlobCache(fs::path folder, std::uint64_t cap_bytes) : folder_(std::move(folder)), cap_(cap_bytes) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error || !fs::is_directory(folder_, error))
        throw EnvironmentError(fmt::format("cannot make the cache folder {}: {}; choose another", folder_.string(),
                                           error ? error.message() : "something else is in its place"));
}

std::optional<Bytes> DiskBlobCache::find(const Hash& hash) {
    const fs::path path = folder_ / hash.hex();
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (error || size > protocol::kMaxBlobBytes) return {};
    Bytes bytes(size);
    std::ifstream in(path, std::ios::binary);
    in.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size));
    if (!in) return {};
    if (sha256(bytes) != hash) {
        fs::remove(path, error);
        return {};
    }
    // Its time is what eviction goes by.
    fs::last_write_time(path, fs::file_time_type::clock::now(), error);
    return bytes;
}

void DiskBlobCache::store(const Hash& hash, ByteView bytes) {
    if (bytes.size() > cap_) return;
    static std::atomic<unsigned> serial = 0;
    const fs::path aside = folder_ / fmt::format("{}.{}.{}{}", hash.hex(), ::getpid(), serial++, kAside);
    std::error_code error;
    if (write_whole(aside, bytes)) fs::rename(aside, folder_ / hash.hex(), error);
    else error = std::make_error_code(std::errc::io_error);
    if (error) {
        std::error_code ignored;
        fs::remove(aside, ignored);
    }
    evict();
}

void DiskBlobCache::evict() {
    struct Kept {
        fs::path path;
        fs::file_time_type used;
        std::uint64_t size;
    };
    std::vector<Kept> files;
    std::uint64_t total = 0;
    std::error_code error;
    const auto now = fs::file_time_type::clock::now();
    for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
        // Other processes add and remove files while we look: what has gone is skipped.
        std::error_code gone;
        const auto used = at->last_write_time(gone);
        if (gone) continue;
        const std::uint64_t size = at->file_size(gone);
        if (gone) continue;
        const std::string name = at->path().filename().string();
        if (name.ends_with(kAside)) {
            if (now - used > kStaleAside) fs::remove(at->path(), gone);
            continue;
        }
        if (name.size() != 64) continue;  // not ours
        files.push_back({at->path(), used, size});
        total += size;
    }
    std::ranges::sort(files, {}, &Kept::used);
    for (const Kept& file : files) {
        if (total <= cap_) break;
        std::error_code gone;
        fs::remove(file.path, gone);
        total -= file.size;
    }
}

}  // namespace mien::net
