#include "io/frame_packet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <string_view>

#include "core/byte_io.hpp"

namespace mien::io {

namespace {

constexpr std::string_view kMagic = "mfrm";
constexpr std::size_t kMaxText = 256;   // bytes of a device's or subject's name

Error truncated(const char* what) { return {ErrorCode::truncated, fmt::format("the {} packet ends early", what)}; }
Error too_long(const char* what, std::size_t bytes) { return {ErrorCode::trailing_bytes, fmt::format("{} bytes too many in the {} packet", bytes, what)}; }

/// Network byte order over ByteReader.
struct BigEndian {
    ByteReader& in;
    std::uint32_t u32() {
        const std::uint32_t v = in.u32();
        return v >> 24 | (v >> 8 & 0xff00) | (v << 8 & 0xff0000) | v << 24;
    }
    std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
    float f32() { return std::bit_cast<float>(u32()); }
    std::string text() {
        const std::uint32_t size = u32();
        if (size > kMaxText) return in.fail(), std::string();
        const ByteView view = in.bytes(size);
        return {reinterpret_cast<const char*>(view.data()), view.size()};
    }
};

void put(ByteWriter& out, std::uint32_t v) { out.u32(v >> 24 | (v >> 8 & 0xff00) | (v << 8 & 0xff0000) | v << 24); }
void put(ByteWriter& out, const std::string& text) {
    put(out, std::uint32_t(text.size()));
    out.bytes(std::as_bytes(std::span(text)));
}

}  // namespace

bool is_marker_packet(ByteView packet) {
    return packet.size() >= kMagic.size() && std::ranges::equal(packet.first(kMagic.size()), std::as_bytes(std::span(kMagic)));
}

Result<MarkerPacket> parse_marker_packet(ByteView bytes) {
    if (!is_marker_packet(bytes)) return Error{ErrorCode::bad_magic, "this is no packet of markers"};
    ByteReader in(bytes.subspan(kMagic.size()));
    const std::uint8_t version = in.u8();
    if (in.ok() && version != MarkerPacket::kVersion)
        return Error{ErrorCode::unsupported_version, fmt::format("a packet of markers of version {}; this program reads version {}", version, MarkerPacket::kVersion)};
    const std::uint8_t reserved = in.u8();
    const std::size_t count = in.u16();
    MarkerPacket packet;
    packet.sequence = in.u32();
    packet.time_us = in.u64();
    if (!in.ok()) return truncated("marker");
    if (reserved != 0) return Error{ErrorCode::invalid, "a byte of the marker packet that must be 0 is not"};
    if (count == 0) return Error{ErrorCode::invalid, "a packet of no markers"};
    if (in.remaining() < count * 12) return truncated("marker");
    if (in.remaining() > count * 12) return too_long("marker", in.remaining() - count * 12);
    packet.markers.resize(Eigen::Index(count), 3);
    for (float& x : packet.markers.reshaped<Eigen::RowMajor>()) x = in.f32();
    for (Eigen::Index m = 0; m < packet.markers.rows(); ++m) {
        auto row = packet.markers.row(m);
        if (row.array().isNaN().any()) row.setConstant(std::numeric_limits<float>::quiet_NaN());
        else if (!row.allFinite()) return Error{ErrorCode::invalid, fmt::format("marker {} is infinite", m)};
    }
    return packet;
}

Bytes encode(const MarkerPacket& packet) {
    assert(packet.markers.rows() > 0 && std::size_t(packet.markers.rows()) <= MarkerPacket::kMaxMarkers);
    ByteWriter out;
    out.bytes(std::as_bytes(std::span(kMagic)));
    out.u8(MarkerPacket::kVersion);
    out.u8(0);
    out.u16(std::uint16_t(packet.markers.rows()));
    out.u32(packet.sequence);
    out.u64(packet.time_us);
    for (Eigen::Index m = 0; m < packet.markers.rows(); ++m)
        for (int i = 0; i < 3; ++i) out.f32(packet.markers(m, i));
    return out.take();
}

Result<LiveLinkPacket> parse_live_link_packet(ByteView bytes) {
    ByteReader in(bytes);
    const std::uint8_t version = in.u8();
    if (!in.ok()) return truncated("Live Link Face");
    if (version != LiveLinkPacket::kVersion)
        return Error{ErrorCode::unsupported_version, fmt::format("no packet of Live Link Face as this program knows it: version {}, not {}", version, LiveLinkPacket::kVersion)};
    BigEndian big{in};
    LiveLinkPacket packet;
    packet.device = big.text();
    packet.subject = big.text();
    packet.frame = big.i32();
    packet.subframe = big.f32();
    packet.rate_numerator = big.i32();
    packet.rate_denominator = big.i32();
    const std::uint8_t count = in.u8();
    if (!in.ok()) return truncated("Live Link Face");
    if (count != LiveLinkPacket::kValues)
        return Error{ErrorCode::invalid, fmt::format("a Live Link Face packet of {} values; this program reads those of {}", count, LiveLinkPacket::kValues)};
    if (packet.rate_numerator <= 0 || packet.rate_denominator <= 0 || !std::isfinite(packet.subframe))
        return Error{ErrorCode::invalid, "the Live Link Face packet has no usable time"};
    for (float& v : packet.values) v = big.f32();
    if (!in.ok()) return truncated("Live Link Face");
    if (in.remaining() > 0) return too_long("Live Link Face", in.remaining());
    for (std::size_t i = 0; i < packet.values.size(); ++i)
        if (!std::isfinite(packet.values[i])) return Error{ErrorCode::invalid, fmt::format("value {} of the Live Link Face packet is not a finite number", i)};
    return packet;
}

Bytes encode(const LiveLinkPacket& packet) {
    assert(packet.device.size() <= kMaxText && packet.subject.size() <= kMaxText);
    ByteWriter out;
    out.u8(LiveLinkPacket::kVersion);
    put(out, packet.device);
    put(out, packet.subject);
    put(out, std::uint32_t(packet.frame));
    put(out, std::bit_cast<std::uint32_t>(packet.subframe));
    put(out, std::uint32_t(packet.rate_numerator));
    put(out, std::uint32_t(packet.rate_denominator));
    out.u8(LiveLinkPacket::kValues);
    for (const float v : packet.values) put(out, std::bit_cast<std::uint32_t>(v));
    return out.take();
}

}  // namespace mien::io
