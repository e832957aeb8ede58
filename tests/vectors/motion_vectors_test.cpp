#include "motion_vectors.hpp"

#include "vector_files.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>

namespace mien::vectors {
namespace {

void write_when_asked() {
    if (!std::getenv("MIEN_WRITE_VECTORS")) return;
    std::ofstream digests(folder() / "motion_digests.txt");
    for (const MotionVector& vector : motion_vectors()) {
        const auto bytes = make_motion_vector(vector);
        ASSERT_TRUE(bytes.ok()) << bytes.error().message;
        write_file(vector.file, *bytes);
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
        const Bytes bytes = read_file(vector.file);
        EXPECT_LT(bytes.size(), 8000u) << vector.file;
        const auto digest = motion_digest(bytes);
        ASSERT_TRUE(digest.ok()) << vector.file << ": " << digest.error().message;
        EXPECT_EQ(*digest, digests[vector.file]) << vector.file << " decodes to other numbers: has the format changed?";
    }
}

}  // namespace
}  // namespace mien::vectors
