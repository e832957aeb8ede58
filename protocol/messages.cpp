#include "protocol/messages.hpp"

#include <fmt/format.h>

#include <cassert>
#include <numeric>

#include "protocol/bodies.hpp"

namespace mien::protocol {

namespace {

std::string_view plain_name(std::uint8_t type) {
    switch (static_cast<MessageType>(type)) {
        case MessageType::header: return "HEADER";
        case MessageType::catalogue: return "CATALOGUE";
        case MessageType::blob: return "BLOB";
        case MessageType::group: return "GROUP";
        case MessageType::end: return "END";
        case MessageType::index: return "INDEX";
        case MessageType::trailer: return "TRAILER";
        case MessageType::group_start: return "GROUP START";
        case MessageType::blob_part: return "BLOB PART";
        case MessageType::hello: return "HELLO";
        case MessageType::list: return "LIST";
        case MessageType::streams: return "STREAMS";
        case MessageType::open: return "OPEN";
        case MessageType::want: return "WANT";
        case MessageType::play: return "PLAY";
        case MessageType::playing: return "PLAYING";
        case MessageType::pause: return "PAUSE";
        case MessageType::seek: return "SEEK";
        case MessageType::rate: return "RATE";
        case MessageType::select: return "SELECT";
        case MessageType::ping: return "PING";
        case MessageType::pong: return "PONG";
        case MessageType::failure: return "FAILURE";
        case MessageType::bye: return "BYE";
        case MessageType::publish: return "PUBLISH";
        case MessageType::publishing: return "PUBLISHING";
        case MessageType::want_part: return "WANT PART";
        case MessageType::live_object: break;
    }
    return type >= 0x40 && type < 0x40 + kMaxSlots ? "LIVE OBJECT" : "";
}

MessageType type_of(const StreamHeader&) { return MessageType::header; }
MessageType type_of(const Catalogue&) { return MessageType::catalogue; }
MessageType type_of(const StaticBlob&) { return MessageType::blob; }
MessageType type_of(const Group&) { return MessageType::group; }
MessageType type_of(const End&) { return MessageType::end; }
MessageType type_of(const Index&) { return MessageType::index; }
MessageType type_of(const Trailer&) { return MessageType::trailer; }
MessageType type_of(const GroupStart&) { return MessageType::group_start; }
MessageType type_of(const LiveBytes& object) {
    assert(object.slot < kMaxSlots);
    return static_cast<MessageType>(0x40 | object.slot);
}
MessageType type_of(const Hello&) { return MessageType::hello; }
MessageType type_of(const ListStreams&) { return MessageType::list; }
MessageType type_of(const StreamList&) { return MessageType::streams; }
MessageType type_of(const Open&) { return MessageType::open; }
MessageType type_of(const Want&) { return MessageType::want; }
MessageType type_of(const Play&) { return MessageType::play; }
MessageType type_of(const Playing&) { return MessageType::playing; }
MessageType type_of(const Pause&) { return MessageType::pause; }
MessageType type_of(const Seek&) { return MessageType::seek; }
MessageType type_of(const SetRate&) { return MessageType::rate; }
MessageType type_of(const Select&) { return MessageType::select; }
MessageType type_of(const Ping&) { return MessageType::ping; }
MessageType type_of(const Pong&) { return MessageType::pong; }
MessageType type_of(const Failure&) { return MessageType::failure; }
MessageType type_of(const Bye&) { return MessageType::bye; }
MessageType type_of(const Publish&) { return MessageType::publish; }
MessageType type_of(const Publishing&) { return MessageType::publishing; }
MessageType type_of(const WantPart&) { return MessageType::want_part; }
MessageType type_of(const BlobPart&) { return MessageType::blob_part; }

template <class T>
Result<Message> as_message(Result<T> result) {
    if (!result) return result.error();
    return Message(std::move(*result));
}

Result<Message> parse_unnamed(std::uint8_t type, ByteView body) {
    if (type >= 0x40 && type < 0x40 + kMaxSlots) {
        if (body.size() > kMaxObjectBytes) return too_large("the object is too large");
        return Message(LiveBytes{static_cast<std::uint8_t>(type & 0x3f), Bytes(body.begin(), body.end())});
    }
    switch (static_cast<MessageType>(type)) {
        case MessageType::header: return as_message(read_header(body));
        case MessageType::catalogue: return as_message(read_catalogue(body));
        case MessageType::blob: return as_message(read_blob(body));
        case MessageType::group: return as_message(read_group(body));
        case MessageType::end: return as_message(read_end(body));
        case MessageType::index: return as_message(read_index(body));
        case MessageType::trailer: return as_message(read_trailer(body));
        case MessageType::group_start: return as_message(read_group_start(body));
        case MessageType::blob_part: return as_message(read_blob_part(body));
        default: return read_control(static_cast<MessageType>(type), body);
    }
}

}  // namespace

std::string name_of(std::uint8_t type) {
    const std::string_view name = plain_name(type);
    return name.empty() ? fmt::format("message 0x{:02x}", type) : std::string(name);
}

Result<void> check_end(const ByteReader& in) {
    if (!in.ok()) return Error{ErrorCode::truncated, "ends early, or a number in it is out of bounds"};
    if (!in.at_end()) return Error{ErrorCode::trailing_bytes, fmt::format("{} bytes too many", in.remaining())};
    return {};
}

void write_checked(ByteWriter& out, const Bytes& covered) {
    out.u32(crc32c(covered));
    out.bytes(covered);
}

bool read_checked(ByteReader& in, ByteView body) {
    const std::uint32_t crc = in.u32();
    return in.ok() && crc == crc32c(body.subspan(in.position()));
}

void write_rational(ByteWriter& out, Rational r) {
    assert(r.num > 0 && r.den > 0 && r.num < (std::int64_t(1) << 31) && r.den < (std::int64_t(1) << 31));
    out.varint(std::uint64_t(r.num));
    out.varint(std::uint64_t(r.den));
}

Rational read_rational(ByteReader& in) {
    const std::uint64_t num = in.varint(), den = in.varint();
    constexpr std::uint64_t limit = std::uint64_t(1) << 31;
    if (in.ok() && num > 0 && den > 0 && num < limit && den < limit && std::gcd(num, den) == 1)
        return {std::int64_t(num), std::int64_t(den)};
    in.fail();
    return {0, 1};
}

Bytes encode(const Message& message) {
    return std::visit(
        [](const auto& content) {
            ByteWriter body;
            write_body(body, content);
            assert(body.size() <= kMaxMessageBytes);
            ByteWriter out;
            out.u8(static_cast<std::uint8_t>(type_of(content)));
            out.varint(body.size());
            out.bytes(body.view());
            return out.take();
        },
        message);
}

Result<MessageHead> parse_head(ByteView bytes, std::uint64_t limit) {
    if (bytes.empty()) return Error{ErrorCode::truncated, "no message follows"};
    ByteReader in(bytes.first(std::min(bytes.size(), kMaxHeadBytes)));
    MessageHead head;
    head.type = in.u8();
    if (plain_name(head.type).empty()) return damaged(fmt::format("0x{:02x} is no type of a message", head.type));
    head.body = in.varint();
    head.size = in.position();
    if (!in.ok()) {
        // Only a varint that stops at the end of what we were given may still become one.
        const bool open_ended = bytes.size() < kMaxHeadBytes && in.at_end() && (std::to_integer<int>(bytes.back()) & 128 || bytes.size() == 1);
        if (open_ended) return Error{ErrorCode::truncated, "the length of a message is cut off"};
        return damaged(name_of(head.type) + ": its length is not a number");
    }
    if (head.body > limit) return too_large(fmt::format("{} of {} bytes; at most {} are taken", name_of(head.type), head.body, limit));
    return head;
}

Result<Message> parse_body(std::uint8_t type, ByteView body) {
    if (plain_name(type).empty()) return damaged(fmt::format("0x{:02x} is no type of a message", type));
    auto message = parse_unnamed(type, body);
    if (!message) return Error{message.error().code, name_of(type) + ": " + message.error().message};
    return message;
}

Result<Message> parse_message(ByteView bytes) {
    MIEN_TRY(head, parse_head(bytes));
    const ByteView body = bytes.subspan(head.size);
    if (body.size() < head.body) return Error{ErrorCode::truncated, name_of(head.type) + " is cut off"};
    if (body.size() > head.body) return Error{ErrorCode::trailing_bytes, "bytes follow " + name_of(head.type)};
    return parse_body(head.type, body);
}

}  // namespace mien::protocol
