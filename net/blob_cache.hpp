#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/hash.hpp"

namespace mien::net {

/// Static blobs kept between runs, by hash. Thread-safe.
class BlobCache {
public:
    virtual ~BlobCache() = default;
    /// The unpacked bytes, already checked against the hash.
    virtual std::optional<Bytes> find(const Hash& hash) = 0;
    /// Keeps a blob. A cache that cannot (disk full) stays silent: it is only a cache.
    virtual void store(const Hash& hash, ByteView bytes) = 0;
};

/// A folder of files named by hash, shared by any number of processes. Files appear whole (written aside, then renamed),
/// are checked on every read and deleted when they are corrupt; the least recently used go when it grows above its cap.
class DiskBlobCache final : public BlobCache {
public:
    static constexpr std::uint64_t kDefaultCap = std::uint64_t(4) << 30;  // bytes: some tens of actors with film textures

    /// Makes the folder. Throws EnvironmentError when that is impossible.
    explicit DiskBlobCache(std::filesystem::path folder = default_folder(), std::uint64_t cap_bytes = kDefaultCap);

    std::optional<Bytes> find(const Hash& hash) override;
    void store(const Hash& hash, ByteView bytes) override;

    const std::filesystem::path& folder() const { return folder_; }
    /// $XDG_CACHE_HOME/mien/blobs, or ~/.cache/mien/blobs.
    static std::filesystem::path default_folder();

private:
    void evict();

    std::filesystem::path folder_;
    std::uint64_t cap_;
};

}  // namespace mien::net
