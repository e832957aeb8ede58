#include "io/frame_packet.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "io/live_link.hpp"

namespace mien::io {
namespace {

Bytes literal(std::initializer_list<int> values) {
    Bytes bytes;
    for (const int v : values) bytes.push_back(static_cast<std::byte>(v));
    return bytes;
}

Bytes two_markers() {
    return literal({
        'm', 'f', 'r', 'm',
        0x01,                                            // version
        0x00,                                            // reserved
        0x02, 0x00,                                      // two markers
        0x07, 0x00, 0x00, 0x80,                          // sequence
        0x40, 0xe2, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,  // 123456 microseconds
        0x00, 0x00, 0x80, 0x3f, 0x00, 0x00, 0x00, 0xc0, 0x00, 0x00, 0x20, 0x41,  // 1, -2, 10 mm
        0x00, 0x00, 0xc0, 0x7f, 0x00, 0x00, 0xc0, 0x7f, 0x00, 0x00, 0xc0, 0x7f,  // missing
    });
}

TEST(MarkerPackets, AreTheseBytes) {
    const auto packet = parse_marker_packet(two_markers());
    ASSERT_TRUE(packet.ok()) << packet.error().message;
    EXPECT_EQ(packet->sequence, 0x80000007u);
    EXPECT_EQ(packet->time_us, 123456u);
    ASSERT_EQ(packet->markers.rows(), 2);
    EXPECT_EQ(packet->markers(0, 0), 1);
    EXPECT_EQ(packet->markers(0, 1), -2);
    EXPECT_EQ(packet->markers(0, 2), 10);
    EXPECT_TRUE(packet->markers.row(1).array().isNaN().all());
    EXPECT_EQ(encode(*packet), two_markers());
}

TEST(MarkerPackets, AMarkerThatLacksACoordinateIsMissingAsInFiles) {
    Bytes bytes = two_markers();
    bytes[35] = std::byte(0);   // of NaN NaN NaN the first is a number
    bytes[30] = std::byte(0xc0), bytes[31] = std::byte(0x7f);   // of 1 -2 10 the last is none
    const auto packet = parse_marker_packet(bytes);
    ASSERT_TRUE(packet.ok()) << packet.error().message;
    EXPECT_TRUE(packet->markers.array().isNaN().all());
}

TEST(MarkerPackets, EveryCutAndEveryByteTooManyIsRefused) {
    const Bytes whole = two_markers();
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(parse_marker_packet(ByteView(whole).first(size)).ok()) << size;
    Bytes longer = whole;
    longer.push_back(std::byte(0));
    EXPECT_EQ(parse_marker_packet(longer).error().code, ErrorCode::trailing_bytes);
}

TEST(MarkerPackets, WhatMakesNoSenseIsRefused) {
    const auto with = [](std::size_t at, int value) {
        Bytes bytes = two_markers();
        bytes[at] = std::byte(value);
        return parse_marker_packet(bytes).error().code;
    };
    EXPECT_EQ(with(0, 'M'), ErrorCode::bad_magic);
    EXPECT_EQ(with(4, 2), ErrorCode::unsupported_version);
    EXPECT_EQ(with(5, 1), ErrorCode::invalid);
    EXPECT_EQ(with(6, 0), ErrorCode::invalid) << "no markers";
    EXPECT_EQ(with(6, 3), ErrorCode::truncated);
    Bytes infinite = two_markers();
    infinite[22] = std::byte(0x80), infinite[23] = std::byte(0x7f);
    EXPECT_EQ(parse_marker_packet(infinite).error().code, ErrorCode::invalid);
}

/// As the app sends it: the strings' and the numbers' bytes are the wrong way round for us.
Bytes face() {
    Bytes bytes = literal({
        0x06,                                     // version
        0x00, 0x00, 0x00, 0x02, 'i', 'd',         // device
        0x00, 0x00, 0x00, 0x03, 'a', 'd', 'a',    // subject
        0x00, 0x00, 0x01, 0x02,                   // frame 258
        0x3f, 0x00, 0x00, 0x00,                   // and a half
        0x00, 0x00, 0x00, 0x3c,                   // 60
        0x00, 0x00, 0x00, 0x01,                   // a second
        0x3d,                                     // 61 values
    });
    for (int i = 0; i < 61; ++i)
        for (const int b : i == 17 ? std::array{0x3e, 0x80, 0x00, 0x00} : std::array{0, 0, 0, 0}) bytes.push_back(std::byte(b));
    return bytes;
}

TEST(LiveLinkPackets, AreTheseBytes) {
    const auto packet = parse_live_link_packet(face());
    ASSERT_TRUE(packet.ok()) << packet.error().message;
    EXPECT_EQ(packet->device, "id");
    EXPECT_EQ(packet->subject, "ada");
    EXPECT_EQ(packet->frame, 258);
    EXPECT_DOUBLE_EQ(packet->seconds(), 258.5 / 60);
    for (std::size_t i = 0; i < packet->values.size(); ++i) EXPECT_EQ(packet->values[i], i == 17 ? 0.25f : 0) << i;
    EXPECT_EQ(encode(*packet), face());
}

TEST(LiveLinkPackets, EveryCutAndWhatMakesNoSenseIsRefused) {
    const Bytes whole = face();
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(parse_live_link_packet(ByteView(whole).first(size)).ok()) << size;
    const auto with = [](std::size_t at, int value) {
        Bytes bytes = face();
        bytes[at] = std::byte(value);
        return parse_live_link_packet(bytes).ok();
    };
    EXPECT_TRUE(with(18, 3));
    EXPECT_FALSE(with(0, 5)) << "another version";
    EXPECT_FALSE(with(1, 1)) << "a name of 16 MB";
    EXPECT_FALSE(with(25, 0)) << "0 frames a second";
    EXPECT_FALSE(with(22, 0x80)) << "a negative rate";
    EXPECT_FALSE(with(30, 60)) << "another count";
    Bytes nan = face();
    nan[31] = std::byte(0x7f), nan[32] = std::byte(0xc0);
    EXPECT_FALSE(parse_live_link_packet(nan).ok());
    Bytes longer = whole;
    longer.push_back(std::byte(0));
    EXPECT_FALSE(parse_live_link_packet(longer).ok());
}

TEST(LiveLinkPackets, AnglesOfPoseAndGazeComeBack) {
    float angles[9] = {0.4f, -0.3f, 0.2f, 0.1f, -0.05f, 0, 0.15f, 0.02f, 0}, back[9] = {};
    live_link_angles(live_link_pose(angles), back);
    live_link_angles(live_link_gaze(angles), back);
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(back[i], angles[i], 1e-6) << i;
}

}  // namespace
}  // namespace mien::io
