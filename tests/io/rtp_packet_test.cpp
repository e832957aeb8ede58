#include "io/rtp_packet.hpp"

#include <gtest/gtest.h>

namespace mien::io {
namespace {

Bytes bytes_of(std::initializer_list<int> values) {
    Bytes bytes;
    for (const int v : values) bytes.push_back(std::byte(v));
    return bytes;
}

TEST(RtpPacket, IsWrittenAsTheRfcHasIt) {
    const Bytes payload = bytes_of({0x12, 0x34, 0xff, 0xfe});
    const Bytes packet = encode(RtpPacket{97, 0x0102, 0xa0b0c0d0, 0x01020304, payload});
    EXPECT_EQ(packet, bytes_of({0x80, 97, 1, 2, 0xa0, 0xb0, 0xc0, 0xd0, 1, 2, 3, 4, 0x12, 0x34, 0xff, 0xfe}));
    const auto back = parse_rtp(packet);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->payload_type, 97);
    EXPECT_EQ(back->sequence, 0x0102);
    EXPECT_EQ(back->timestamp, 0xa0b0c0d0u);
    EXPECT_EQ(back->source, 0x01020304u);
    const auto sound = parse_l16(back->payload, 48000, 2);
    ASSERT_TRUE(sound.ok());
    EXPECT_EQ(sound->samples, (std::vector<float>{0x1234 / 32768.0f, -2 / 32768.0f}));
    EXPECT_EQ(encode_l16(*sound), payload);
}

TEST(RtpPacket, SourcesExtensionMarkerAndPaddingArePassedOver) {
    // One contributing source, an extension of one word, marker bit, two bytes of padding.
    const Bytes packet = bytes_of({0xb1, 0x80 | 11, 0, 7, 0, 0, 0, 9, 0, 0, 0, 1, 5, 5, 5, 5, 0xbe, 0xde, 0, 1, 1, 2, 3, 4, 0x40, 0, 0, 2});
    const auto parsed = parse_rtp(packet);
    ASSERT_TRUE(parsed.ok()) << parsed.error().message;
    EXPECT_EQ(parsed->payload_type, 11);
    ASSERT_EQ(parsed->payload.size(), 2u);
    EXPECT_EQ(parse_l16(parsed->payload, 44100, 1)->samples, std::vector<float>{0.5f});
    for (std::size_t size = 0; size < packet.size(); ++size) {
        const auto cut = parse_rtp(ByteView(packet).first(size));   // the last byte is padding's count, whatever it is now
        if (cut.ok()) {
            EXPECT_LE(cut->payload.size(), size - 12) << size;
        }
    }
    EXPECT_FALSE(parse_rtp(ByteView(packet).first(19)).ok());
}

TEST(RtpPacket, WhatIsNoneIsRefused) {
    EXPECT_EQ(parse_rtp({}).error().code, ErrorCode::truncated);
    EXPECT_EQ(parse_rtp(Bytes(40)).error().code, ErrorCode::unsupported_version);
    Bytes padded = encode(RtpPacket{96, 0, 0, 0, {}});
    padded[0] |= std::byte(32);
    EXPECT_FALSE(parse_rtp(padded).ok()) << "no byte of padding where there must be one";
    Bytes extended = encode(RtpPacket{96, 0, 0, 0, {}});
    extended[0] |= std::byte(16);
    EXPECT_FALSE(parse_rtp(extended).ok());
    EXPECT_FALSE(parse_l16(bytes_of({1, 2, 3}), 48000, 1).ok());
    EXPECT_FALSE(parse_l16(bytes_of({1, 2}), 48000, 2).ok());
    EXPECT_EQ(encode_l16({48000, 1, {2, -2}}), bytes_of({0x7f, 0xff, 0x80, 0})) << "clipped";
}

}  // namespace
}  // namespace mien::io
