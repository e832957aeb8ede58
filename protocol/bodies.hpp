#pragma once

#include "core/byte_io.hpp"
#include "protocol/messages.hpp"

/// The body of each message, written and read; messages.cpp puts type and length around them. Internal to this room.
namespace mien::protocol {

inline constexpr std::string_view kMagic = "mien";

/// After the last field: everything was there, and nothing is left over.
Result<void> check_end(const ByteReader& in);
inline Error damaged(std::string message) { return {ErrorCode::damaged, std::move(message)}; }
inline Error too_large(std::string message) { return {ErrorCode::limit_exceeded, std::move(message)}; }

/// Writes the CRC-32C of `covered`, then `covered`.
void write_checked(ByteWriter& out, const Bytes& covered);
/// Reads a CRC-32C and tests it against all that follows.
bool read_checked(ByteReader& in, ByteView body);

/// A fraction in lowest terms, both parts 1 .. 2^31 - 1, as two varints.
void write_rational(ByteWriter& out, Rational r);
Rational read_rational(ByteReader& in);  ///< {0, 1} and a failed reader when it is none

void write_body(ByteWriter& out, const StreamHeader& header);
void write_body(ByteWriter& out, const Catalogue& catalogue);
void write_body(ByteWriter& out, const StaticBlob& blob);
void write_body(ByteWriter& out, const Group& group);
void write_body(ByteWriter& out, const End& end);
void write_body(ByteWriter& out, const Index& index);
void write_body(ByteWriter& out, const Trailer& trailer);
void write_body(ByteWriter& out, const GroupStart& start);
void write_body(ByteWriter& out, const LiveBytes& object);
void write_body(ByteWriter& out, const Hello& hello);
void write_body(ByteWriter& out, const ListStreams& list);
void write_body(ByteWriter& out, const StreamList& list);
void write_body(ByteWriter& out, const Open& open);
void write_body(ByteWriter& out, const Want& want);
void write_body(ByteWriter& out, const Play& play);
void write_body(ByteWriter& out, const Playing& playing);
void write_body(ByteWriter& out, const Pause& pause);
void write_body(ByteWriter& out, const Seek& seek);
void write_body(ByteWriter& out, const SetRate& rate);
void write_body(ByteWriter& out, const Select& select);
void write_body(ByteWriter& out, const Ping& ping);
void write_body(ByteWriter& out, const Pong& pong);
void write_body(ByteWriter& out, const Failure& failure);
void write_body(ByteWriter& out, const Bye& bye);
void write_body(ByteWriter& out, const Publish& publish);
void write_body(ByteWriter& out, const Publishing& publishing);
void write_body(ByteWriter& out, const WantPart& want);
void write_body(ByteWriter& out, const BlobPart& part);

Result<StreamHeader> read_header(ByteView body);
Result<Catalogue> read_catalogue(ByteView body);
Result<StaticBlob> read_blob(ByteView body);
Result<Group> read_group(ByteView body);
Result<End> read_end(ByteView body);
Result<Index> read_index(ByteView body);
Result<Trailer> read_trailer(ByteView body);
Result<GroupStart> read_group_start(ByteView body);
Result<BlobPart> read_blob_part(ByteView body);
/// HELLO to WANT PART, of which none carries anything large.
Result<Message> read_control(MessageType type, ByteView body);

}  // namespace mien::protocol
