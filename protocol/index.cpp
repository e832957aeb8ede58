#include <fmt/format.h>

#include <array>
#include <cassert>

#include "protocol/bodies.hpp"

namespace mien::protocol {

namespace {

/// What an entry is predicted from: the last ones of its slot. Groups are evenly spaced, so the time is expected to go
/// on as it did and the object count to stay; an entry then costs six to eight bytes.
struct Expectation {
    std::int64_t time = 0, time_before = 0;
    std::int64_t objects = 0;

    std::int64_t next_time() const { return 2 * time - time_before; }
    void learn(const IndexEntry& entry) {
        time_before = std::exchange(time, entry.first_time);
        objects = entry.objects;
    }
};

}  // namespace

void write_body(ByteWriter& out, const Index& index) {
    ByteWriter rest;
    rest.varint(index.entries.size());
    std::array<Expectation, kMaxSlots> slots;
    std::int64_t group = 0;
    std::uint64_t at = 0;
    for (const IndexEntry& entry : index.entries) {
        assert(entry.slot < kMaxSlots && entry.offset >= at);
        Expectation& expected = slots[entry.slot];
        rest.u8(entry.slot);
        rest.svarint(entry.group - group);
        rest.svarint(entry.first_time - expected.next_time());
        rest.svarint(std::int64_t(entry.objects) - expected.objects);
        rest.varint(entry.offset - at);
        rest.varint(entry.size);
        expected.learn(entry);
        group = entry.group;
        at = entry.offset + entry.size;
    }
    write_checked(out, rest.view());
}

Result<Index> read_index(ByteView body) {
    ByteReader in(body);
    if (!read_checked(in, body)) return damaged("its checksum does not match");
    constexpr std::size_t smallest_entry = 6;
    const std::uint64_t count = in.varint();
    if (count > in.remaining() / smallest_entry) return Error{ErrorCode::truncated, "has fewer bytes than entries"};
    Index index;
    index.entries.reserve(count);
    std::array<Expectation, kMaxSlots> slots;
    std::int64_t group = 0;
    std::uint64_t at = 0;
    for (std::uint64_t e = 0; e < count; ++e) {
        const std::uint8_t slot = in.u8();
        const std::int64_t group_step = in.svarint(), time_error = in.svarint(), objects_error = in.svarint();
        const std::uint64_t gap = in.varint(), size = in.varint();
        if (!in.ok()) break;
        const auto far = [](std::int64_t v) { return v > 8 * kMaxTicks || v < -8 * kMaxTicks; };
        if (slot >= kMaxSlots || far(group_step) || far(time_error) || far(objects_error) || gap > std::uint64_t(kMaxTicks) ||
            size > kMaxMessageBytes + kMaxHeadBytes)
            return damaged(fmt::format("entry {} is out of range", e));
        Expectation& expected = slots[slot];
        const std::int64_t time = expected.next_time() + time_error, objects = expected.objects + objects_error;
        group += group_step;
        if (group < 0 || group > std::int64_t(kMaxGroups) || objects < 0 || objects > std::int64_t(kMaxGroupObjects) ||
            time > kMaxTicks || time < -kMaxTicks || at > std::uint64_t(kMaxTicks))
            return damaged(fmt::format("entry {} is out of range", e));
        const IndexEntry entry{slot, static_cast<std::uint32_t>(group), time, static_cast<std::uint32_t>(objects), at + gap, size};
        index.entries.push_back(entry);
        expected.learn(entry);
        at = entry.offset + entry.size;
    }
    MIEN_CHECK(check_end(in));
    return index;
}

void write_body(ByteWriter& out, const End& end) { out.varint(end.frames); }

Result<End> read_end(ByteView body) {
    ByteReader in(body);
    const End end{in.varint()};
    MIEN_CHECK(check_end(in));
    if (end.frames > std::uint64_t(kMaxTicks)) return damaged("its length is impossible");
    return end;
}

void write_body(ByteWriter& out, const Trailer& trailer) {
    ByteWriter offset;
    offset.u64(trailer.index_offset);
    out.bytes(offset.view());
    out.u32(crc32c(offset.view()));
    out.bytes(std::as_bytes(std::span(kMagic)));
}

Result<Trailer> read_trailer(ByteView body) {
    ByteReader in(body);
    const Trailer trailer{in.u64()};
    const std::uint32_t crc = in.u32();
    const ByteView magic = in.bytes(kMagic.size());
    MIEN_CHECK(check_end(in));
    if (!std::ranges::equal(magic, std::as_bytes(std::span(kMagic))) || crc != crc32c(body.first(8)))
        return damaged("its checksum or its last four bytes do not match");
    return trailer;
}

}  // namespace mien::protocol
