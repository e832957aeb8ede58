#include "model_vectors.hpp"

#include "vector_files.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace mien::vectors {
namespace {

void write_when_asked() {
    if (!std::getenv("MIEN_WRITE_VECTORS")) return;
    std::ofstream digests(folder() / "model_digests.txt");
    for (const ModelVector& vector : model_vectors()) {
        const auto bytes = make_model_vector(vector);
        ASSERT_TRUE(bytes.ok()) << bytes.error().message;
        write_file(vector.file, *bytes);
        const auto lines = model_digests(*bytes);
        ASSERT_TRUE(lines.ok()) << lines.error().message;
        for (const std::string& line : *lines) digests << vector.file << " " << line << "\n";
    }
}

TEST(ModelVectors, DecodeToTheSameNumbersOnEveryBuild) {
    write_when_asked();
    std::string found;
    for (const ModelVector& vector : model_vectors()) {
        const Bytes bytes = read_file(vector.file);
        EXPECT_LT(bytes.size(), 8000u) << vector.file;
        const auto lines = model_digests(bytes);
        ASSERT_TRUE(lines.ok()) << vector.file << ": " << lines.error().message;
        for (const std::string& line : *lines) found += vector.file + " " + line + "\n";
    }
    EXPECT_EQ(found, read_text("model_digests.txt")) << "a model decodes to other numbers: has the format changed?";
}

}  // namespace
}  // namespace mien::vectors
