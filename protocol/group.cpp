#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "protocol/bodies.hpp"

namespace mien::protocol {

namespace {

/// How the frames per object are written: the two top bits of the slot byte.
enum FramesMode : std::uint8_t { kOneEach = 0, kSameEach = 1, kOwnEach = 2 };

FramesMode mode_of(const Group& group) {
    const bool same = std::ranges::all_of(group.objects, [&](const Object& o) { return o.frames == group.objects[0].frames; });
    if (!same) return kOwnEach;
    return group.objects.empty() || group.objects[0].frames == 1 ? kOneEach : kSameEach;
}

/// All of a group's body but checksum and payload.
void write_table(ByteWriter& out, const Group& group) {
    assert(group.slot < kMaxSlots && group.objects.size() <= kMaxGroupObjects && group.group <= kMaxGroups);
    const FramesMode mode = mode_of(group);
    out.u8(static_cast<std::uint8_t>(group.slot | mode << 6));
    out.varint(group.group);
    out.svarint(group.first_time);
    out.varint(group.objects.size());
    if (mode == kSameEach) out.varint(group.objects[0].frames);
    if (mode == kOwnEach)
        for (const Object& object : group.objects) out.varint(object.frames);
    // Neighbours are alike, so differences are short; the last length follows from the message's.
    std::int64_t previous = 0;
    for (std::size_t i = 0; i + 1 < group.objects.size(); ++i) {
        const auto size = std::int64_t(group.objects[i].bytes.size());
        out.svarint(size - previous);
        previous = size;
    }
}

struct Table {
    Group group;                        ///< objects with their frames, still without bytes
    std::vector<std::uint64_t> sizes;   ///< of each object but the last
};

Result<GroupHead> read_group_head(ByteReader& in, std::uint8_t& mode) {
    GroupHead head;
    const std::uint8_t slot = in.u8();
    const std::uint64_t number = in.varint();
    head.first_time = in.svarint();
    const std::uint64_t objects = in.varint();
    if (!in.ok()) return Error{ErrorCode::truncated, "ends early"};
    mode = slot >> 6;
    if (mode > kOwnEach) return damaged("its frames per object are written in an unknown way");
    if (number > kMaxGroups || objects > kMaxGroupObjects)
        return too_large(fmt::format("group {} of {} objects", number, objects));
    if (head.first_time > kMaxTicks || head.first_time < -kMaxTicks) return damaged("its time is impossible");
    head.slot = slot & 63;
    head.group = static_cast<std::uint32_t>(number);
    head.objects = static_cast<std::uint32_t>(objects);
    return head;
}

Result<Table> read_table(ByteReader& in) {
    std::uint8_t mode = kOneEach;
    MIEN_TRY(head, read_group_head(in, mode));
    Table table;
    table.group = {head.slot, head.group, head.first_time, {}};
    // Every object but the last costs at least one byte here, so the table cannot promise more than the body holds.
    if (head.objects > in.remaining() + 1) return Error{ErrorCode::truncated, "has fewer bytes than objects"};
    table.group.objects.resize(head.objects);
    bool all_same = true;
    if (mode == kSameEach || mode == kOwnEach) {
        std::uint64_t frames = mode == kSameEach ? in.varint() : 0;
        for (Object& object : table.group.objects) {
            if (mode == kOwnEach) frames = in.varint();
            if (!in.ok()) return Error{ErrorCode::truncated, "ends early"};
            if (frames == 0 || frames > kMaxObjectFrames) return damaged(fmt::format("an object of {} frames", frames));
            object.frames = static_cast<std::uint32_t>(frames);
            all_same = all_same && object.frames == table.group.objects[0].frames;
        }
        const bool shortest = mode == kOwnEach ? !all_same : !table.group.objects.empty() && frames != 1;
        if (!shortest) return damaged("its frames per object are not written in the shortest way");
    }
    std::int64_t size = 0;
    for (std::size_t i = 0; i + 1 < head.objects; ++i) {
        const std::int64_t step = in.svarint();
        if (!in.ok()) return Error{ErrorCode::truncated, "ends early"};
        constexpr auto limit = std::int64_t(kMaxObjectBytes);
        if (step > limit || step < -limit || size + step < 0 || size + step > limit)
            return damaged(fmt::format("object {} has an impossible length", i));
        size += step;
        table.sizes.push_back(std::uint64_t(size));
    }
    return table;
}

}  // namespace

void write_body(ByteWriter& out, const Group& group) {
    ByteWriter rest;
    write_table(rest, group);
    for (const Object& object : group.objects) {
        assert(object.bytes.size() <= kMaxObjectBytes && object.frames >= 1 && object.frames <= kMaxObjectFrames);
        rest.bytes(object.bytes);
    }
    write_checked(out, rest.view());
}

std::uint64_t group_framing(const Group& group) {
    ByteWriter out;
    write_table(out, group);
    std::uint64_t payload = 0;
    for (const Object& object : group.objects) payload += object.bytes.size();
    const std::uint64_t table = 4 + out.size();
    ByteWriter length;
    length.varint(table + payload);
    return 1 + length.size() + table;
}

Result<Group> read_group(ByteView body) {
    ByteReader in(body);
    if (!read_checked(in, body)) return damaged("its checksum does not match");
    MIEN_TRY(table, read_table(in));
    for (std::size_t i = 0; i < table.group.objects.size(); ++i) {
        const bool last = i + 1 == table.group.objects.size();
        const ByteView bytes = in.bytes(last ? in.remaining() : table.sizes[i]);
        if (bytes.size() > kMaxObjectBytes) return too_large(fmt::format("object {} has {} bytes", i, bytes.size()));
        table.group.objects[i].bytes.assign(bytes.begin(), bytes.end());
    }
    MIEN_CHECK(check_end(in));
    return std::move(table.group);
}

Result<Group> parse_cut_group(ByteView body, [[maybe_unused]] std::uint64_t full_size) {
    assert(body.size() < full_size);
    ByteReader in(body);
    in.u32();
    MIEN_TRY(table, read_table(in));
    std::vector<Object>& objects = table.group.objects;
    std::size_t whole = 0;
    for (; whole < table.sizes.size() && table.sizes[whole] <= in.remaining(); ++whole) {
        const ByteView bytes = in.bytes(table.sizes[whole]);
        objects[whole].bytes.assign(bytes.begin(), bytes.end());
    }
    if (whole == 0) return Error{ErrorCode::truncated, "not one of its objects is whole"};
    objects.resize(whole);
    return std::move(table.group);
}

Result<GroupHead> parse_group_head(ByteView body) {
    ByteReader in(body);
    in.u32();
    std::uint8_t mode = kOneEach;
    return read_group_head(in, mode);
}

void write_body(ByteWriter& out, const GroupStart& start) {
    assert(start.slot < kMaxSlots && start.group <= kMaxGroups && start.frames >= 1);
    out.u8(start.slot);
    out.varint(start.group);
    out.svarint(start.first_time);
    out.varint(start.frames);
}

Result<GroupStart> read_group_start(ByteView body) {
    ByteReader in(body);
    GroupStart start;
    start.slot = in.u8();
    const std::uint64_t number = in.varint();
    start.first_time = in.svarint();
    const std::uint64_t frames = in.varint();
    MIEN_CHECK(check_end(in));
    if (start.slot >= kMaxSlots || number > kMaxGroups || start.first_time > kMaxTicks || start.first_time < -kMaxTicks ||
        frames == 0 || frames > kMaxObjectFrames)
        return damaged("a slot, group, time or frame count is out of range");
    start.group = static_cast<std::uint32_t>(number);
    start.frames = static_cast<std::uint32_t>(frames);
    return start;
}

void write_body(ByteWriter& out, const LiveBytes& object) { out.bytes(object.bytes); }

}  // namespace mien::protocol
