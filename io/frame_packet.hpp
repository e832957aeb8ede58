#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry.hpp"
#include "core/hash.hpp"
#include "core/result.hpp"

/// Frames of motion as single UDP packets (docs/live.md).
namespace mien::io {

/// One frame of markers, in a packet of mien's own. Little-endian: "mfrm", u8 version (1), u8 0, u16 markers, u32 sequence, u64 time, then x y z of each
/// marker as f32.
struct MarkerPacket {
    static constexpr std::uint8_t kVersion = 1;
    static constexpr std::size_t kHead = 20;        ///< bytes before the markers
    static constexpr std::size_t kMaxMarkers = 5456;  ///< that fit in one UDP packet

    std::uint32_t sequence = 0;      ///< number of the frame, at the stream's frame rate
    std::uint64_t time_us = 0;       ///< of the capture, by the sender's clock
    Points markers;                  ///< mm; three NaNs: missing. In a packet one is enough
};
bool is_marker_packet(ByteView packet);
/// Errors: bad_magic, unsupported_version, truncated, trailing_bytes; invalid for a marker that is infinite.
Result<MarkerPacket> parse_marker_packet(ByteView packet);
Bytes encode(const MarkerPacket& packet);

/// One frame as the app Live Link Face sends it (Unreal's own protocol, version 6). Big-endian: u8 version, text device and text subject (i32 length and bytes
/// each), i32 frame, f32 part of a frame, i32 and i32 frame rate, u8 count, count x f32: 52 weights in the app's order, then yaw, pitch and roll of head, left
/// eye and right eye, radians.
struct LiveLinkPacket {
    static constexpr std::uint8_t kVersion = 6;
    static constexpr std::size_t kWeights = 52, kValues = 61;

    std::string device, subject;
    std::int32_t frame = 0;          ///< since midnight, at rate_numerator / rate_denominator
    float subframe = 0;
    std::int32_t rate_numerator = 60, rate_denominator = 1;
    std::array<float, kValues> values{};

    double seconds() const { return (double(frame) + double(subframe)) * rate_denominator / rate_numerator; }
};
/// Errors: unsupported_version, truncated, trailing_bytes; invalid for another count, a frame rate that is none, a value that is not finite.
Result<LiveLinkPacket> parse_live_link_packet(ByteView packet);
Bytes encode(const LiveLinkPacket& packet);

}  // namespace mien::io
