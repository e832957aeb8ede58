#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/hash.hpp"
#include "core/result.hpp"
#include "protocol/limits.hpp"
#include "protocol/stream.hpp"

/// Bytes <-> messages. Files and the wire share them all: a message is a type byte, the length of its body as a varint,
/// and the body. docs/format.md gives the bytes of the messages a file is made of, docs/protocol.md those of the wire.
namespace mien::protocol {

/// Of HEADER and the model manifest, in files and on the wire. Other versions are refused by name.
inline constexpr std::uint32_t kVersion = 4;
/// Of HELLO: what a viewer, a publisher and a server say to each other, and when. Likewise.
inline constexpr std::uint32_t kWireVersion = 5;

enum class MessageType : std::uint8_t {
    // What a stream is made of: in files and on the wire.
    header = 0x01,
    catalogue = 0x02,
    blob = 0x03,
    group = 0x04,
    end = 0x05,
    // Only in files: they close one.
    index = 0x06,
    trailer = 0x07,
    // Only on the wire.
    group_start = 0x08,
    blob_part = 0x09,
    hello = 0x20,
    list = 0x21,
    streams = 0x22,
    open = 0x23,
    want = 0x24,
    play = 0x25,
    playing = 0x26,
    pause = 0x27,
    seek = 0x28,
    rate = 0x29,
    select = 0x2a,
    ping = 0x2b,
    pong = 0x2c,
    failure = 0x2d,
    bye = 0x2e,
    publish = 0x2f,
    publishing = 0x30,
    want_part = 0x31,
    // 0x40 | slot: one object of a live stream.
    live_object = 0x40,
};
/// "GROUP", "LIVE OBJECT"; "message 0x7f" for what has no name.
std::string name_of(std::uint8_t type);
/// HELLO to WANT PART: short messages, the only ones that a server takes from a viewer.
constexpr bool is_control(std::uint8_t type) { return type >= 0x20 && type < 0x40; }
/// "shape", "motion basis", ...; empty for what is none.
std::string_view name_of(BlobKind kind);

/// The recorded stream is complete; no group follows.
struct End {
    std::uint64_t frames = 0;      ///< of the visual tracks
};
/// Where everything lies in a file, in the file's order.
struct Index {
    std::vector<IndexEntry> entries;
};
/// The last message of a file, always kTrailerBytes long, so that a reader finds the index from the end.
struct Trailer {
    std::uint64_t index_offset = 0;  ///< bytes from the start of the file to the INDEX message
};
inline constexpr std::size_t kTrailerBytes = 18;

/// Opens a group of one slot of a live stream; the LIVE OBJECTs of that slot that follow are its objects 0, 1, 2, ...
struct GroupStart {
    std::uint8_t slot = 0;
    std::uint32_t group = 0;
    std::int64_t first_time = 0;   ///< ticks, of object 0
    std::uint32_t frames = 1;      ///< frames or packets that each object holds
};
/// A live object as it crosses TCP: its group, index and time follow from the last GROUP START of its slot.
struct LiveBytes {
    std::uint8_t slot = 0;
    Bytes bytes;
};

/// The first message of either side.
struct Hello {
    std::uint32_t version = kWireVersion;
    std::string software;          ///< "mien-play 0.1.0"; for logs only
};
struct ListStreams {};
struct StreamEntry {
    std::string name;
    Rational frame_rate{30, 1};
    std::uint64_t frames = 0;      ///< 0 while live
    bool live = false;

    double seconds() const { return double(frames) / frame_rate.value(); }
};
struct StreamList {
    std::vector<StreamEntry> streams;
};
/// Asks for HEADER and CATALOGUE of a stream.
struct Open {
    std::string name;
};
/// Asks for the static blobs that the client does not hold; they come in this order.
struct Want {
    std::vector<Hash> hashes;
};
/// Asks for some bytes of the BLOB message of one static blob, so that what is more urgent never waits for a whole one.
struct WantPart {
    Hash hash;
    std::uint64_t offset = 0;      ///< bytes from the message's start
    std::uint32_t bytes = 0;       ///< 1 .. kMaxPartBytes; fewer come at its end
};
/// The bytes that WANT PART asked for.
struct BlobPart {
    std::uint64_t total = 0;       ///< bytes of the whole BLOB message
    Bytes bytes;                   ///< at least one
};
/// Starts playing from the group that contains `time`. `rate` in thousandths; 0: unpaced, as fast as the client takes it.
struct Play {
    std::uint32_t generation = 0;
    std::uint64_t time_us = 0;
    std::uint32_t rate = 1000;
};
/// From the server: all groups that follow answer the PLAY or SEEK of this generation; the first one is of `group`.
struct Playing {
    std::uint32_t generation = 0;
    std::uint32_t group = 0;
};
/// The play position stops (or goes on). What is under way still arrives.
struct Pause {
    bool paused = true;
};
/// As PLAY, keeping rate and pause.
struct Seek {
    std::uint32_t generation = 0;
    std::uint64_t time_us = 0;
};
struct SetRate {
    std::uint32_t rate = 1000;     ///< thousandths; 0: unpaced
};
/// Only these slots are sent, from the next group on: bit s is slot s. May come any time after OPEN.
struct Select {
    std::uint64_t slots = ~std::uint64_t(0);
};
struct Ping {
    std::uint64_t token = 0;       ///< comes back unchanged; the sender's clock, for instance
};
struct Pong {
    std::uint64_t token = 0;
    std::uint64_t clock_us = 0;    ///< the answering side's monotonic clock
};
enum class FailureCode : std::uint8_t {
    version = 1,      ///< The other side speaks another version.
    protocol = 2,     ///< A message that cannot be parsed or has no place here.
    no_such_stream = 3,
    no_such_blob = 4,
    damaged = 5,      ///< The stored stream cannot be read.
    busy = 6,         ///< Too many viewers.
    timeout = 7,
    shutting_down = 8,
    no_publishing = 9,  ///< The server takes no streams, or not from there.
    name_taken = 10,    ///< Somebody else publishes under this name, or it is that of a recording.
};
/// Why the sender closes the connection after this message.
struct Failure {
    FailureCode code = FailureCode::protocol;
    std::string text;
};
struct Bye {};
/// Asks to send a live stream under this name; HEADER and CATALOGUE follow at once.
struct Publish {
    std::string name;
};
/// The server takes the stream. Groups and times go on from those that viewers have had under this name and header.
struct Publishing {
    std::uint32_t group = 0;       ///< the least number that the first GROUP START may have
    std::uint64_t frames = 0;      ///< visual frames before: its least time, in frames
};

using Message = std::variant<StreamHeader, Catalogue, StaticBlob, Group, End, Index, Trailer, GroupStart, LiveBytes, Hello,
                             ListStreams, StreamList, Open, Want, Play, Playing, Pause, Seek, SetRate, Select, Ping, Pong,
                             Failure, Bye, Publish, Publishing, WantPart, BlobPart>;

/// A whole message: type, length and body. Static blobs are packed with zstd when that makes them smaller.
Bytes encode(const Message& message);

/// Type and body length of a message.
struct MessageHead {
    std::uint8_t type = 0;
    std::uint64_t body = 0;    ///< bytes of the body
    std::size_t size = 0;      ///< bytes of type and length themselves: the body starts there

    std::uint64_t total() const { return size + body; }
};
inline constexpr std::size_t kMaxHeadBytes = 6;   ///< type, and a varint up to kMaxMessageBytes

/// The head at the start of `bytes`. `truncated` when more bytes could still make one; `damaged` and `limit_exceeded`
/// when none can: unknown type, a length above `limit`.
Result<MessageHead> parse_head(ByteView bytes, std::uint64_t limit = kMaxMessageBytes);

/// The message with this type and exactly this body. Everything is checked: bounds, checksums, hashes, no byte left over.
Result<Message> parse_body(std::uint8_t type, ByteView body);

/// A whole message and nothing after it.
Result<Message> parse_message(ByteView bytes);

/// The leading whole objects of a GROUP whose body was cut after `body.size()` of `full_size` bytes; the checksum cannot
/// be tested. `truncated` when not even one object is whole.
Result<Group> parse_cut_group(ByteView body, std::uint64_t full_size);

/// What identifies a GROUP, without its objects: for scanning. `body` may end anywhere behind the object count.
struct GroupHead {
    std::uint8_t slot = 0;
    std::uint32_t group = 0;
    std::int64_t first_time = 0;
    std::uint32_t objects = 0;
};
Result<GroupHead> parse_group_head(ByteView body);
inline constexpr std::size_t kMaxGroupHeadBytes = 24;  ///< of the body, up to and with the object count

/// What identifies a BLOB, without its bytes.
struct BlobHead {
    Hash hash;
    BlobKind kind = BlobKind::manifest;
    bool packed = false;             ///< zstd
    std::uint64_t unpacked = 0;      ///< bytes
    std::size_t size = 0;            ///< bytes of this head in the body; the stored bytes follow
};
Result<BlobHead> parse_blob_head(ByteView body);
inline constexpr std::size_t kMaxBlobHeadBytes = 40;

/// Bytes a group's message spends beside its objects' own.
std::uint64_t group_framing(const Group& group);

/// The bytes of a manifest blob and back.
Bytes encode_manifest(const Manifest& manifest);
Result<Manifest> parse_manifest(ByteView bytes);

}  // namespace mien::protocol
