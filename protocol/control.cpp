#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "protocol/bodies.hpp"

namespace mien::protocol {

namespace {

/// The longest start of `text` that fits and does not end inside a character.
std::string_view clip_text(std::string_view text, std::size_t limit) {
    if (text.size() <= limit) return text;
    while (limit > 0 && (static_cast<unsigned char>(text[limit]) & 0xc0) == 0x80) --limit;
    return text.substr(0, limit);
}

template <class T>
Result<Message> finish(const ByteReader& in, T content) {
    MIEN_CHECK(check_end(in));
    return Message(std::move(content));
}

std::uint32_t generation(ByteReader& in) {
    const std::uint64_t value = in.varint();
    if (value > 0xffffffffu) in.fail();
    return static_cast<std::uint32_t>(value);
}
std::uint64_t time_us(ByteReader& in) {
    const std::uint64_t value = in.varint();
    if (value > std::uint64_t(kMaxTicks)) in.fail();
    return value;
}
std::uint32_t rate(ByteReader& in) {
    const std::uint64_t value = in.varint();
    if (value > kMaxRate) in.fail();
    return static_cast<std::uint32_t>(value);
}

Result<Message> read_hello(ByteReader& in) {
    const ByteView magic = in.bytes(kMagic.size());
    if (!in.ok() || !std::ranges::equal(magic, std::as_bytes(std::span(kMagic))))
        return Error{ErrorCode::bad_magic, "the other side does not speak mien"};
    const std::uint64_t version = in.varint();
    // What follows belongs to the other version.
    if (in.ok() && version != kWireVersion)
        return Error{ErrorCode::unsupported_version,
                     fmt::format("the other side speaks version {}, this program speaks version {}", version, kWireVersion)};
    return finish(in, Hello{kWireVersion, in.text(kMaxName)});
}

Result<Message> read_streams(ByteReader& in) {
    const std::uint64_t count = in.varint();
    if (count > kMaxStreams) return too_large(fmt::format("{} streams; at most {} are taken", count, kMaxStreams));
    StreamList list;
    for (std::uint64_t s = 0; s < count && in.ok(); ++s) {
        StreamEntry entry;
        entry.name = in.text(kMaxName);
        entry.frame_rate = read_rational(in);
        entry.frames = in.varint();
        const std::uint8_t live = in.u8();
        if (live > 1 || entry.frames > std::uint64_t(kMaxTicks)) in.fail();
        entry.live = live == 1;
        list.streams.push_back(std::move(entry));
    }
    return finish(in, std::move(list));
}

Result<Message> read_want(ByteReader& in) {
    const std::uint64_t count = in.varint();
    if (count > kMaxBlobs) return too_large(fmt::format("{} static blobs; at most {} are taken", count, kMaxBlobs));
    Want want;
    for (std::uint64_t b = 0; b < count && in.ok(); ++b) want.hashes.push_back(in.hash());
    return finish(in, std::move(want));
}

}  // namespace

void write_body(ByteWriter& out, const Hello& hello) {
    out.bytes(std::as_bytes(std::span(kMagic)));
    out.varint(hello.version);
    out.text(clip_text(hello.software, kMaxName));
}
void write_body(ByteWriter&, const ListStreams&) {}
void write_body(ByteWriter& out, const StreamList& list) {
    assert(list.streams.size() <= kMaxStreams);
    out.varint(list.streams.size());
    for (const StreamEntry& entry : list.streams) {
        assert(entry.name.size() <= kMaxName);
        out.text(entry.name);
        write_rational(out, entry.frame_rate);
        out.varint(entry.frames);
        out.u8(entry.live);
    }
}
void write_body(ByteWriter& out, const Open& open) {
    assert(open.name.size() <= kMaxName);
    out.text(open.name);
}
void write_body(ByteWriter& out, const Want& want) {
    assert(want.hashes.size() <= kMaxBlobs);
    out.varint(want.hashes.size());
    for (const Hash& hash : want.hashes) out.hash(hash);
}
void write_body(ByteWriter& out, const Play& play) {
    out.varint(play.generation);
    out.varint(play.time_us);
    out.varint(play.rate);
}
void write_body(ByteWriter& out, const Playing& playing) {
    out.varint(playing.generation);
    out.varint(playing.group);
}
void write_body(ByteWriter& out, const Pause& pause) { out.u8(pause.paused); }
void write_body(ByteWriter& out, const Seek& seek) {
    out.varint(seek.generation);
    out.varint(seek.time_us);
}
void write_body(ByteWriter& out, const SetRate& rate) { out.varint(rate.rate); }
void write_body(ByteWriter& out, const Select& select) { out.u64(select.slots); }
void write_body(ByteWriter& out, const Ping& ping) { out.u64(ping.token); }
void write_body(ByteWriter& out, const Pong& pong) {
    out.u64(pong.token);
    out.u64(pong.clock_us);
}
void write_body(ByteWriter& out, const Failure& failure) {
    out.u8(static_cast<std::uint8_t>(failure.code));
    out.text(clip_text(failure.text, kMaxText));
}
void write_body(ByteWriter&, const Bye&) {}
void write_body(ByteWriter& out, const Publish& publish) {
    assert(publish.name.size() <= kMaxName);
    out.text(publish.name);
}
void write_body(ByteWriter& out, const Publishing& publishing) {
    out.varint(publishing.group);
    out.varint(publishing.frames);
}

void write_body(ByteWriter& out, const WantPart& want) {
    assert(want.bytes > 0 && want.bytes <= kMaxPartBytes && want.offset < kMaxMessageBytes + kMaxHeadBytes);
    out.hash(want.hash);
    out.varint(want.offset);
    out.varint(want.bytes);
}

Result<Message> read_control(MessageType type, ByteView body) {
    ByteReader in(body);
    switch (type) {
        case MessageType::hello: return read_hello(in);
        case MessageType::list: return finish(in, ListStreams{});
        case MessageType::streams: return read_streams(in);
        case MessageType::open: {
            Open open{in.text(kMaxName)};
            return finish(in, std::move(open));
        }
        case MessageType::want: return read_want(in);
        case MessageType::play: {
            const Play play{.generation = generation(in), .time_us = time_us(in), .rate = rate(in)};
            return finish(in, play);
        }
        case MessageType::playing: {
            Playing playing{.generation = generation(in)};
            const std::uint64_t group = in.varint();
            if (group > kMaxGroups) in.fail();
            playing.group = static_cast<std::uint32_t>(group);
            return finish(in, playing);
        }
        case MessageType::pause: {
            const std::uint8_t paused = in.u8();
            if (paused > 1) in.fail();
            return finish(in, Pause{paused == 1});
        }
        case MessageType::seek: {
            const Seek seek{.generation = generation(in), .time_us = time_us(in)};
            return finish(in, seek);
        }
        case MessageType::rate: {
            const SetRate set{rate(in)};
            return finish(in, set);
        }
        case MessageType::select: {
            const Select select{in.u64()};
            return finish(in, select);
        }
        case MessageType::ping: {
            const Ping ping{in.u64()};
            return finish(in, ping);
        }
        case MessageType::pong: {
            const Pong pong{.token = in.u64(), .clock_us = in.u64()};
            return finish(in, pong);
        }
        case MessageType::failure: {
            const std::uint8_t code = in.u8();
            if (code < 1 || code > static_cast<std::uint8_t>(FailureCode::name_taken)) in.fail();
            Failure failure{static_cast<FailureCode>(code), in.text(kMaxText)};
            return finish(in, std::move(failure));
        }
        case MessageType::bye: return finish(in, Bye{});
        case MessageType::publish: {
            Publish publish{in.text(kMaxName)};
            return finish(in, std::move(publish));
        }
        case MessageType::publishing: {
            Publishing publishing;
            const std::uint64_t group = in.varint();
            publishing.frames = in.varint();
            if (group > kMaxGroups || publishing.frames > std::uint64_t(kMaxTicks)) in.fail();
            publishing.group = static_cast<std::uint32_t>(group);
            return finish(in, publishing);
        }
        case MessageType::want_part: {
            WantPart want;
            want.hash = in.hash();
            want.offset = in.varint();
            const std::uint64_t bytes = in.varint();
            if (want.offset >= kMaxMessageBytes + kMaxHeadBytes || bytes < 1 || bytes > kMaxPartBytes) in.fail();
            want.bytes = static_cast<std::uint32_t>(bytes);
            return finish(in, want);
        }
        default: return damaged("this type is no control message");
    }
}

}  // namespace mien::protocol
