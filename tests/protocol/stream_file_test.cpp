#include "protocol/stream_file.hpp"

#include <gtest/gtest.h>

#include "sample_stream.hpp"

namespace mien::protocol {
namespace {

using namespace sample;

/// The bytes of one message of a file and where it lies.
struct Place {
    std::uint8_t type = 0;
    std::size_t offset = 0, size = 0;
};
std::vector<Place> places_of(const Bytes& file) {
    std::vector<Place> places;
    for (std::size_t at = 0; at < file.size();) {
        const auto head = parse_head(ByteView(file).subspan(at));
        EXPECT_TRUE(head.ok());
        if (!head) break;
        places.push_back({head->type, at, std::size_t(head->total())});
        at += head->total();
    }
    return places;
}

TEST(StreamFile, ReadsBackWhatWasWritten) {
    const Stream stream = make_stream(3);
    const Bytes file = file_of(stream);
    auto reader = open_bytes(file);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_TRUE(reader->complete()) << reader->complaint();
    EXPECT_EQ(encode(reader->header()), encode(stream.header));
    EXPECT_EQ(reader->manifest().actor, "ada");
    ASSERT_EQ(reader->index().size(), stream.groups.size());
    EXPECT_EQ(reader->groups(), (std::vector<std::uint32_t>{0, 1, 2}));
    for (const Group& group : stream.groups) {
        const auto back = reader->read_group(group.slot, group.group);
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_TRUE(same(*back, group));
    }
    for (const StaticBlob& blob : stream.blobs) {
        const auto back = reader->blob(blob.hash);
        ASSERT_TRUE(back.ok()) << back.error().message;
        EXPECT_EQ(*back, blob.bytes);
    }
    EXPECT_EQ(reader->read_group(0, 3).error().code, ErrorCode::missing);
    EXPECT_EQ(reader->blob(Hash{}).error().code, ErrorCode::missing);
    EXPECT_DOUBLE_EQ(reader->seconds(), 3.0);
}

TEST(StreamFile, IsNothingButMessages) {
    const Bytes file = file_of(make_stream(2));
    std::string types;
    for (const Place& place : places_of(file)) {
        EXPECT_TRUE(parse_message(ByteView(file).subspan(place.offset, place.size)).ok()) << name_of(place.type);
        types += name_of(place.type).front();
    }
    // HEADER CATALOGUE BLOB x 4 GROUP x 6 END INDEX TRAILER
    EXPECT_EQ(types, "HCBBBBGGGGGGEIT");
}

TEST(StreamFile, FindsTheGroupThatContainsATime) {
    const Bytes file = file_of(make_stream(3));
    const auto reader = open_bytes(file);
    ASSERT_TRUE(reader.ok());
    EXPECT_EQ(reader->group_at(-5), 0u);
    EXPECT_EQ(reader->group_at(0), 0u);
    EXPECT_EQ(reader->group_at(0.99), 0u);
    EXPECT_EQ(reader->group_at(1), 1u);
    EXPECT_EQ(reader->group_at(2.5), 2u);
    EXPECT_EQ(reader->group_at(1e9), 2u);
    EXPECT_EQ(reader->first_entry(1), 3u);
    EXPECT_EQ(reader->first_entry(9), reader->index().size());
}

TEST(StreamFile, SpendsNoMoreOnFramingThanItsBudget) {
    // Short and long objects, at the start of a stream and three hours into it.
    for (const auto& [texture_bytes, hours] : {std::pair(30, 0), std::pair(900, 0), std::pair(30, 3), std::pair(4000, 3)}) {
        Stream stream = make_stream(100, texture_bytes);
        for (Group& group : stream.groups) {
            group.group += hours * 3600u;
            group.first_time += hours * 3600 * (group.slot == 2 ? 48000 : 30);
        }
        std::uint64_t objects = 0, framing = 0;
        for (const Group& group : stream.groups) {
            objects += group.objects.size();
            framing += group_framing(group);
        }
        const Bytes file = file_of(stream);
        const std::vector<Place> places = places_of(file);
        const Place& index = places[places.size() - 2];
        ASSERT_EQ(index.type, static_cast<std::uint8_t>(MessageType::index));
        EXPECT_LE(framing + index.size, 2 * objects + 24 * stream.groups.size());
        // The index alone, which every player of a file reads first.
        EXPECT_LE(index.size, 9 * stream.groups.size());
    }
}

TEST(StreamFile, AGroupOfOneLongObjectStaysInItsBudgetHoweverLateItComes) {
    // One object of 200 kB a group, after 200 000 groups and 200 000 s of 48 kHz.
    Group group{63, 200000, std::int64_t(200000) * 48000, {{1, Bytes(200000)}}};
    EXPECT_LE(group_framing(group), 2u + 24u - 7u);
}

TEST(StreamFile, AccountsForEveryByte) {
    const Stream stream = make_stream(4);
    const Bytes file = file_of(stream);
    const auto reader = open_bytes(file);
    ASSERT_TRUE(reader.ok());
    const auto sum = reader->account();
    ASSERT_TRUE(sum.ok());
    std::uint64_t stored = sum->framing;
    for (const auto& blob : sum->blobs) stored += blob.stored;
    for (const auto& [slot, content] : sum->slots) stored += content.payload;
    EXPECT_EQ(stored, file.size());
    EXPECT_EQ(sum->total, file.size());
    EXPECT_EQ(sum->slots.at(1).objects, 120u);
    EXPECT_EQ(sum->slots.at(1).groups, 4u);
    std::uint64_t texture = 0;
    for (const Group& group : stream.groups)
        if (group.slot == 1)
            for (const Object& object : group.objects) texture += object.bytes.size();
    EXPECT_EQ(sum->slots.at(1).payload, texture);
    EXPECT_LT(sum->blobs[2].stored, 300u) << "300 equal bytes are packed";
}

TEST(StreamFile, PlaysToTheLastWholeObjectWhereverItIsCut) {
    const Stream stream = make_tiny_stream();
    const Bytes file = file_of(stream);
    const std::vector<Place> places = places_of(file);
    std::size_t front = 0;
    for (const Place& place : places)
        if (place.type <= static_cast<std::uint8_t>(MessageType::blob)) front = place.offset + place.size;

    for (std::size_t size = 0; size < file.size(); ++size) {
        const Bytes cut(file.begin(), file.begin() + std::ptrdiff_t(size));
        auto reader = open_bytes(cut);
        if (size < front) {
            EXPECT_FALSE(reader.ok()) << size;
            continue;
        }
        ASSERT_TRUE(reader.ok()) << size << ": " << reader.error().message;
        EXPECT_FALSE(reader->complete());
        // Every object that lies wholly before the cut comes back, and no other.
        std::size_t whole = 0, got = 0;
        std::size_t g = 0;
        for (const Place& place : places) {
            if (place.type != static_cast<std::uint8_t>(MessageType::group)) continue;
            const Group& group = stream.groups[g++];
            std::size_t end = place.offset + place.size;
            for (auto object = group.objects.rbegin(); object != group.objects.rend(); ++object) {
                whole += end <= size;
                end -= object->bytes.size();
            }
        }
        for (const IndexEntry& entry : reader->index()) {
            const auto group = reader->read_group(entry);
            ASSERT_TRUE(group.ok()) << size << ": " << group.error().message;
            got += group->objects.size();
            EXPECT_EQ(entry.objects, group->objects.size());
            const auto message = reader->group_message(entry);
            ASSERT_TRUE(message.ok());
            EXPECT_TRUE(parse_message(*message).ok()) << "what a server sends on is a whole message";
        }
        EXPECT_EQ(got, whole) << "cut after " << size << " bytes";
        EXPECT_TRUE(reader->account().ok());
    }
}

TEST(StreamFile, RebuildsAMissingOrDamagedIndex) {
    const Stream stream = make_stream(3);
    const Bytes file = file_of(stream);
    const std::vector<Place> places = places_of(file);
    const Place end = places[places.size() - 3], index = places[places.size() - 2], trailer = places.back();
    const auto expect_all_groups = [&](const Bytes& damaged) {
        const auto reader = open_bytes(damaged);
        ASSERT_TRUE(reader.ok()) << reader.error().message;
        EXPECT_FALSE(reader->complete());
        ASSERT_EQ(reader->index().size(), stream.groups.size());
        for (const Group& group : stream.groups) {
            const auto back = reader->read_group(group.slot, group.group);
            ASSERT_TRUE(back.ok()) << back.error().message;
            EXPECT_TRUE(same(*back, group));
        }
    };
    for (const Place& place : {end, index, trailer}) {
        expect_all_groups(Bytes(file.begin(), file.begin() + std::ptrdiff_t(place.offset)));
        for (std::size_t i = 0; i < place.size; ++i) {
            Bytes damaged = file;
            damaged[place.offset + i] ^= std::byte{0x15};
            if (place.offset == end.offset && i == 2) continue;  // END's frame count alone carries no checksum
            expect_all_groups(damaged);
        }
    }
}

TEST(StreamFile, RefusesDamageInTheStaticPartsByName) {
    const Stream stream = make_tiny_stream();
    const Bytes file = file_of(stream);
    const std::vector<Place> places = places_of(file);
    const auto opens_wholly = [](const Bytes& bytes) -> Result<void> {
        MIEN_TRY(reader, open_bytes(bytes));
        for (const BlobInfo& blob : reader.catalogue().blobs) MIEN_CHECK(reader.blob(blob.hash));
        return {};
    };
    ASSERT_TRUE(opens_wholly(file).ok());
    const char* names[] = {"stream header", "catalogue", "model manifest", "shape", "connectivity", "motion basis"};
    for (int part = 0; part < 6; ++part) {
        for (std::size_t i = 0; i < places[part].size; ++i) {
            for (const int flip : {1, 0x80, 0xff}) {
                Bytes damaged = file;
                damaged[places[part].offset + i] ^= static_cast<std::byte>(flip);
                const auto result = opens_wholly(damaged);
                // Some bits inside zstd's frame mean nothing; what was unpacked has the right hash.
                if (part == 4 && i > 40 && result.ok()) continue;
                ASSERT_FALSE(result.ok()) << names[part] << " byte " << i;
                const std::string& message = result.error().message;
                const bool named = message.find(names[part]) != std::string::npos;
                // The first bytes say what the file is; when they go, it is no stream, or one of another version.
                const bool whole = part == 0 && i < 8 &&
                                   (message.find("not a mien stream") != std::string::npos || message.find("version") != std::string::npos);
                EXPECT_TRUE(named || whole) << names[part] << " byte " << i << ": " << message;
            }
        }
    }
}

TEST(StreamFile, LosesOnlyTheGroupThatIsDamaged) {
    const Stream stream = make_tiny_stream();
    const Bytes file = file_of(stream);
    const std::vector<Place> places = places_of(file);
    // With the index, and without it: then the scan has to find its way round the damage.
    const std::size_t without_index = places[places.size() - 2].offset;
    for (const bool indexed : {true, false}) {
        std::size_t g = 0;
        for (const Place& place : places) {
            if (place.type != static_cast<std::uint8_t>(MessageType::group)) continue;
            const Group& hit = stream.groups[g++];
            for (std::size_t i = 0; i < place.size; ++i) {
                for (const int flip : {1, 0x80, 0xff}) {
                    Bytes damaged(file.begin(), file.begin() + std::ptrdiff_t(indexed ? file.size() : without_index));
                    damaged[place.offset + i] ^= static_cast<std::byte>(flip);
                    const auto reader = open_bytes(damaged);
                    ASSERT_TRUE(reader.ok());
                    EXPECT_EQ(reader->complete(), indexed);
                    EXPECT_FALSE(reader->read_group(hit.slot, hit.group).ok()) << "group " << g - 1 << " byte " << i;
                    for (const Group& group : stream.groups) {
                        if (&group == &hit) continue;
                        const auto back = reader->read_group(group.slot, group.group);
                        ASSERT_TRUE(back.ok()) << "group " << g - 1 << " byte " << i << " flip " << flip << (indexed ? "" : ", scanned")
                                               << ": " << back.error().message;
                        EXPECT_TRUE(same(*back, group));
                    }
                }
            }
        }
    }
}

TEST(StreamFile, NoDamagedByteAnywhereCrashesIt) {
    const Bytes file = file_of(make_tiny_stream());
    for (std::size_t i = 0; i < file.size(); ++i) {
        for (const int value : {0x00, 0xff, int(std::to_integer<int>(file[i]) ^ 0x20)}) {
            Bytes damaged = file;
            damaged[i] = static_cast<std::byte>(value);
            const auto reader = open_bytes(damaged);
            if (!reader) continue;
            for (const BlobInfo& blob : reader->catalogue().blobs) (void)reader->blob(blob.hash).ok();
            for (const IndexEntry& entry : reader->index()) {
                (void)reader->read_group(entry).ok();
                (void)reader->group_message(entry).ok();
            }
            EXPECT_TRUE(reader->account().ok());
        }
    }
}

TEST(StreamFile, RefusesAnotherVersionByName) {
    Bytes file = file_of(make_tiny_stream());
    const auto head = parse_head(file);
    ASSERT_TRUE(head.ok());
    file[head->size + 4] = std::byte{9};
    const auto reader = open_bytes(file);
    ASSERT_FALSE(reader.ok());
    EXPECT_EQ(reader.error().code, ErrorCode::unsupported_version);
    EXPECT_NE(reader.error().message.find("version 9"), std::string::npos) << reader.error().message;
}

TEST(StreamFile, RefusesWhatIsNoStream) {
    for (const std::string_view text : {"", "x", "mien", "{\"fps\": 30}", "RIFF....WAVEfmt and so on"}) {
        const Bytes file = bytes_of(text);
        const auto reader = open_bytes(file);
        ASSERT_FALSE(reader.ok());
        EXPECT_EQ(reader.error().code, ErrorCode::bad_magic) << text;
    }
}

TEST(StreamFile, OrdersGroupsByNumberThenSlot) {
    std::vector<Group> groups = {{1, 1, 0, {}}, {0, 1, 0, {}}, {2, 0, 0, {}}, {0, 0, 0, {}}};
    order_groups(groups);
    std::vector<std::pair<int, int>> order;
    for (const Group& group : groups) order.emplace_back(group.group, group.slot);
    EXPECT_EQ(order, (std::vector<std::pair<int, int>>{{0, 0}, {0, 2}, {1, 0}, {1, 1}}));
}

}  // namespace
}  // namespace mien::protocol
