#include "net/blob_cache.hpp"

#include <cstdlib>

#include "harness.hpp"

namespace mien::net {
namespace {

using namespace harness;
using protocol::sample::noise;

std::size_t files_in(const std::filesystem::path& folder) {
    return std::size_t(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(DiskBlobCache, GivesBackWhatItKept) {
    const Folder folder;
    DiskBlobCache cache(folder.path() / "not" / "made" / "yet");
    const Bytes bytes = noise(5000, 1);
    EXPECT_FALSE(cache.find(sha256(bytes)).has_value());
    cache.store(sha256(bytes), bytes);
    EXPECT_EQ(cache.find(sha256(bytes)), bytes);
    // Another process sees it too.
    DiskBlobCache other(cache.folder());
    EXPECT_EQ(other.find(sha256(bytes)), bytes);
    EXPECT_EQ(files_in(cache.folder()), 1u) << "nothing half-written stays behind";
}

TEST(DiskBlobCache, DeletesWhatIsCorrupt) {
    const Folder folder;
    DiskBlobCache cache(folder.path());
    const Bytes bytes = noise(5000, 2);
    cache.store(sha256(bytes), bytes);
    Bytes damaged = bytes;
    damaged[1234] ^= std::byte{1};
    for (const Bytes& wrong : {damaged, Bytes(bytes.begin(), bytes.begin() + 100), Bytes()}) {
        folder.write(sha256(bytes).hex(), wrong);
        EXPECT_FALSE(cache.find(sha256(bytes)).has_value());
        EXPECT_EQ(files_in(folder.path()), 0u);
    }
    cache.store(sha256(bytes), bytes);
    EXPECT_EQ(cache.find(sha256(bytes)), bytes);
}

TEST(DiskBlobCache, DropsWhatWasUsedLongestAgo) {
    const Folder folder;
    DiskBlobCache cache(folder.path(), 3500);
    std::vector<Bytes> blobs;
    const auto age = [&](const Bytes& bytes, int hours) {
        std::filesystem::last_write_time(folder.path() / sha256(bytes).hex(),
                                         std::filesystem::file_time_type::clock::now() - std::chrono::hours(hours));
    };
    for (std::uint32_t b = 0; b < 3; ++b) {
        blobs.push_back(noise(1000, b));
        cache.store(sha256(blobs[b]), blobs[b]);
        age(blobs[b], 10 - int(b));
    }
    EXPECT_TRUE(cache.find(sha256(blobs[0])).has_value());  // now the youngest
    folder.write("a note of somebody else", noise(9000, 9));
    folder.write(sha256(blobs[0]).hex() + ".1.0.part", noise(100, 3));
    const Bytes fourth = noise(1000, 4);
    cache.store(sha256(fourth), fourth);
    EXPECT_TRUE(cache.find(sha256(blobs[0])).has_value());
    EXPECT_FALSE(cache.find(sha256(blobs[1])).has_value());
    EXPECT_TRUE(cache.find(sha256(blobs[2])).has_value());
    EXPECT_TRUE(cache.find(sha256(fourth)).has_value());
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "a note of somebody else"));
    EXPECT_TRUE(std::filesystem::exists(folder.path() / (sha256(blobs[0]).hex() + ".1.0.part"))) << "somebody may be writing it";
    cache.store(sha256(noise(4000, 5)), noise(4000, 5));  // larger than the whole cache
    EXPECT_FALSE(cache.find(sha256(noise(4000, 5))).has_value());
}

TEST(DiskBlobCache, StandsManyWritersOfOneBlob) {
    const Folder folder;
    const Bytes bytes = noise(200000, 6);
    std::vector<std::thread> threads;
    std::atomic<int> wrong = 0;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            DiskBlobCache cache(folder.path());
            for (int i = 0; i < 20; ++i) {
                cache.store(sha256(bytes), bytes);
                if (cache.find(sha256(bytes)) != bytes) ++wrong;
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(DiskBlobCache, SaysWhereItCannotBe) {
    const Folder folder;
    folder.write("file", noise(1, 1));
    EXPECT_THROW(DiskBlobCache(folder.path() / "file"), EnvironmentError);
}

}  // namespace
}  // namespace mien::net
