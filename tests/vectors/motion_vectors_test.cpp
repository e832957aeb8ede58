#include "motion_vectors.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

namespace mien::vectors {
namespace {

std::filesystem::path folder() { return std::filesystem::path(MIEN_SOURCE_DIR) / "tests" / "vectors"; }

Bytes read_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    Bytes bytes(text.size());
    std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return std::byte(c); });
    return bytes;
}

void write_when_asked() {
    if (!std::getenv("MIEN_WRITE_VECTORS")) return;
    std::ofstream digests(folder() / "motion_digests.txt");
    for (const MotionVector& vector : motion_vectors()) {
        const auto bytes = make_motion_vector(vector);
        ASSERT_TRUE(bytes.ok()) << bytes.error().message;
        std::ofstream(folder() / vector.file, std::ios::binary).write(reinterpret_cast<const char*>(bytes->data()), std::streamsize(bytes->size()));
        digests << vector.file << " " << *motion_digest(*bytes) << "\n";
    }
}

TEST(MotionVectors, DecodeToTheSameNumbersOnEveryBuild) {
    write_when_asked();
    std::ifstream in(folder() / "motion_digests.txt");
    std::map<std::string, std::string> digests;
    for (std::string file, digest; in >> file >> digest;) digests[file] = digest;
    ASSERT_EQ(digests.size(), motion_vectors().size());
    for (const MotionVector& vector : motion_vectors()) {
        const Bytes bytes = read_file(folder() / vector.file);
        EXPECT_LT(bytes.size(), 8000u) << vector.file;
        const auto digest = motion_digest(bytes);
        ASSERT_TRUE(digest.ok()) << vector.file << ": " << digest.error().message;
        EXPECT_EQ(*digest, digests[vector.file]) << vector.file << " decodes to other numbers: has the format changed?";
    }
}

}  // namespace
}  // namespace mien::vectors
