#pragma once

#include <cstdint>

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::io {

/// A packet of the Real-time Transport Protocol (RFC 3550, section 5.1), as capture tools send sound in it.
struct RtpPacket {
    std::uint8_t payload_type = 96;  ///< 0 to 127; from 96 on: as both sides have agreed
    std::uint16_t sequence = 0;      ///< of packets; may wrap
    std::uint32_t timestamp = 0;     ///< samples of the sender's clock, of the first sample; may wrap
    std::uint32_t source = 0;        ///< the sender's own number (SSRC)
    ByteView payload;
};
/// The payload points into `packet`. Errors: truncated; unsupported_version for anything but version 2.
Result<RtpPacket> parse_rtp(ByteView packet);
Bytes encode(const RtpPacket& packet);

/// L16 (RFC 3551, section 4.5.11): 16-bit samples, big-endian, channels interleaved. Errors: invalid for part of a sample.
Result<Sound> parse_l16(ByteView payload, int sample_rate, int channels);
Bytes encode_l16(const Sound& sound);

}  // namespace mien::io
