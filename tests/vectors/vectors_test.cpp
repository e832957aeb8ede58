#include "vectors.hpp"

#include "model_vectors.hpp"
#include "motion_vectors.hpp"

#include "vector_files.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <set>

namespace mien::vectors {
namespace {

/// After a format change on purpose: MIEN_WRITE_VECTORS=1 test_vectors
void write_when_asked() {
    if (!std::getenv("MIEN_WRITE_VECTORS")) return;
    std::ofstream table(folder() / "README.md");
    table << "# Conformance vectors\n\nMade by `vectors.cpp`; `test_vectors` holds them against it and against what a reader must make of\n"
             "them. After a change of the format on purpose: `MIEN_WRITE_VECTORS=1 test_vectors`.\n\n| file | bytes | what it shows |\n| --- | --- | --- |\n";
    for (const Vector& vector : make_vectors()) {
        write_file(vector.file, vector.bytes);
        table << "| `" << vector.file << "` | " << vector.bytes.size() << " | " << vector.shows << " |\n";
    }
    for (const MotionVector& vector : motion_vectors())
        table << "| `" << vector.file << "` | " << std::filesystem::file_size(folder() / vector.file) << " | " << vector.shows << " |\n";
    for (const ModelVector& vector : model_vectors())
        table << "| `" << vector.file << "` | " << std::filesystem::file_size(folder() / vector.file) << " | " << vector.shows << " |\n";
    table << "\n`motion_digests.txt`: what the motion in the `motion_` files decodes to; `model_digests.txt`: every layer of the `model_` files. An encoder of another build\n"
             "may choose other bytes for these files; what a decoder makes of them is fixed.\n";
}

TEST(Vectors, AreMadeAgainByteForByte) {
    write_when_asked();
    for (const Vector& vector : make_vectors()) {
        if (vector.made_again) {
            EXPECT_TRUE(read_file(vector.file) == vector.bytes)
                << vector.file << " differs from what this build writes: has the format changed?";
        }
        EXPECT_LT(vector.bytes.size(), 8000u);
    }
}

TEST(Vectors, ReadAsTheyMust) {
    for (const Vector& vector : make_vectors()) {
        const Bytes file = read_file(vector.file);
        const auto reader = protocol::sample::open_bytes(file);
        if (vector.refused) {
            ASSERT_FALSE(reader.ok()) << vector.file;
            EXPECT_EQ(reader.error().code, *vector.refused) << vector.file << ": " << reader.error().message;
            continue;
        }
        ASSERT_TRUE(reader.ok()) << vector.file << ": " << reader.error().message;
        EXPECT_EQ(reader->complete(), vector.complete) << vector.file << ": " << reader->complaint();
        std::size_t objects = 0, lost = 0;
        for (const protocol::IndexEntry& entry : reader->index()) {
            const auto group = reader->read_group(entry);
            if (group)
                objects += group->objects.size();
            else
                ++lost;
        }
        EXPECT_EQ(objects, vector.objects) << vector.file;
        EXPECT_EQ(lost, vector.lost_groups) << vector.file;
        for (const protocol::BlobInfo& blob : reader->catalogue().blobs) EXPECT_TRUE(reader->blob(blob.hash).ok()) << vector.file;
        if (!vector.stream) continue;
        ASSERT_EQ(reader->catalogue().blobs.size(), vector.stream->blobs.size()) << vector.file;
        for (const protocol::StaticBlob& blob : vector.stream->blobs) {
            const auto read = reader->blob(blob.hash);
            EXPECT_TRUE(read.ok() && *read == blob.bytes) << vector.file;
        }
        ASSERT_EQ(reader->index().size(), vector.stream->groups.size()) << vector.file;
        for (std::size_t g = 0; g < vector.stream->groups.size(); ++g) {
            const auto group = reader->read_group(reader->index()[g]);
            EXPECT_TRUE(group.ok() && protocol::sample::same(*group, vector.stream->groups[g])) << vector.file << " group " << g;
        }
    }
}

TEST(Vectors, TheConversationHasEveryMessageOfTheWire) {
    const Bytes wire = read_file(folder() / "conversation.wire");
    std::set<std::size_t> kinds;
    for (std::size_t at = 0; at < wire.size();) {
        const auto head = protocol::parse_head(ByteView(wire).subspan(at));
        ASSERT_TRUE(head.ok());
        const auto message = protocol::parse_message(ByteView(wire).subspan(at, head->total()));
        ASSERT_TRUE(message.ok()) << message.error().message;
        kinds.insert(message->index());
        at += head->total();
    }
    // All but INDEX and TRAILER, which only files have.
    EXPECT_EQ(kinds.size(), std::variant_size_v<protocol::Message> - 2);
}

}  // namespace
}  // namespace mien::vectors
