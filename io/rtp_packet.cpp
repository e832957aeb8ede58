#include "io/rtp_packet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mien::io {
namespace {

constexpr std::size_t kHead = 12;  // bytes

std::uint32_t big_endian(ByteView bytes, std::size_t at, int count) {
    std::uint32_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + std::size_t(i)]);
    return value;
}

void put(Bytes& out, std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) out.push_back(std::byte(value >> (8 * i) & 255));
}

}  // namespace

Result<RtpPacket> parse_rtp(ByteView bytes) {
    const auto truncated = [] { return Error{ErrorCode::truncated, "the RTP packet ends early"}; };
    if (bytes.size() < kHead) return truncated();
    const std::uint32_t flags = big_endian(bytes, 0, 1);
    if (flags >> 6 != 2) return Error{ErrorCode::unsupported_version, fmt::format("this is no RTP packet of version 2 (its version would be {})", flags >> 6)};
    RtpPacket packet;
    packet.payload_type = std::uint8_t(big_endian(bytes, 1, 1) & 127);
    packet.sequence = std::uint16_t(big_endian(bytes, 2, 2));
    packet.timestamp = big_endian(bytes, 4, 4);
    packet.source = big_endian(bytes, 8, 4);
    std::size_t begin = kHead + 4 * (flags & 15), end = bytes.size();  // contributing sources
    if (flags & 16) {                                                 // extension
        if (begin + 4 > end) return truncated();
        begin += 4 + 4 * std::size_t(big_endian(bytes, begin + 2, 2));
    }
    if (flags & 32) {  // padding, counted by its last byte
        const std::size_t padding = big_endian(bytes, end - 1, 1);
        if (padding == 0 || padding > end - kHead) return truncated();
        end -= padding;
    }
    if (begin > end) return truncated();
    packet.payload = bytes.subspan(begin, end - begin);
    return packet;
}

Bytes encode(const RtpPacket& packet) {
    Bytes out;
    out.reserve(kHead + packet.payload.size());
    put(out, 2u << 6, 1);
    put(out, packet.payload_type & 127u, 1);
    put(out, packet.sequence, 2);
    put(out, packet.timestamp, 4);
    put(out, packet.source, 4);
    out.insert(out.end(), packet.payload.begin(), packet.payload.end());
    return out;
}

Result<Sound> parse_l16(ByteView payload, int sample_rate, int channels) {
    if (payload.size() % (2 * std::size_t(channels)) != 0)
        return Error{ErrorCode::invalid, fmt::format("{} bytes are no whole samples of {} x 16 bits", payload.size(), channels)};
    Sound sound{sample_rate, channels, {}};
    sound.samples.reserve(payload.size() / 2);
    for (std::size_t at = 0; at < payload.size(); at += 2) sound.samples.push_back(float(std::int16_t(big_endian(payload, at, 2))) / 32768);
    return sound;
}

Bytes encode_l16(const Sound& sound) {
    Bytes out;
    out.reserve(2 * sound.samples.size());
    for (const float sample : sound.samples) put(out, std::uint16_t(std::int16_t(std::lrint(std::clamp(sample * 32768, -32768.0f, 32767.0f)))), 2);
    return out;
}

}  // namespace mien::io
