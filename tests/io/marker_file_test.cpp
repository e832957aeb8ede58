#include "io/marker_file.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "core/byte_io.hpp"
#include "tests/recordings.hpp"

namespace mien::io {
namespace {

using tests::recordings;

Result<MarkerTake> parse_csv(std::string_view text) {
    MIEN_TRY(table, parse_number_table(text));
    return parse_marker_table(table);
}

TEST(MarkerTable, BlanksAreMissingAndLeftOutFramesAreEmpty) {
    const auto take = parse_csv("\xef\xbb\xbf" "frame,time_s,Nose_x,Nose_y,Nose_z,Chin_x,Chin_y,Chin_z\r\n"
                                "10,0.000000,1,2,3,4,5,6\r\n11,0.016667,1,,3,4,5,6\r\n13,0.050000,7,8,9,,,\r\n14,0.066667,1,2,3,4,5,6\r\n");
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_EQ(take->names, (std::vector<std::string>{"Nose", "Chin"}));
    EXPECT_EQ(take->frame_rate, (Rational{60, 1}));
    ASSERT_EQ(take->points.frames, 5);
    ASSERT_EQ(take->points.points, 2);
    EXPECT_EQ(take->points.frame(0)(1, 2), 6);
    EXPECT_TRUE(take->points.frame(1).row(0).array().isNaN().all());
    EXPECT_EQ(take->points.frame(1)(1, 0), 4);
    EXPECT_TRUE(take->points.frame(2).array().isNaN().all());  // frame 12
    EXPECT_EQ(take->points.frame(3)(0, 0), 7);
    EXPECT_TRUE(take->points.frame(3).row(1).array().isNaN().all());
    EXPECT_EQ(take->warnings.size(), 1u);
    EXPECT_EQ(take->partly_missing.text(), "marker 0 of frame 1");
}

TEST(MarkerTable, PlainColumnsAreThreePerMarker) {
    const auto take = parse_csv("1 2 3 4 5 6\n1 2 3 4 5 7\n");
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_EQ(take->points.points, 2);
    EXPECT_EQ(take->points.frame(1)(1, 2), 7);
    EXPECT_FALSE(parse_csv("1,2,3,4\n"));
    EXPECT_FALSE(parse_csv("a_x,a_y\n1,2\n"));
    EXPECT_FALSE(parse_csv("a_x,a_y,a_z,a_x\n1,2,3,4\n"));
    EXPECT_NE(parse_csv("a_x,a_y,a_z\n1,2,x\n").error().message.find("a_z"), std::string::npos);
    EXPECT_NE(parse_csv("a_x,a_y,a_z\n1,2,3,4\n").error().message.find("line 2"), std::string::npos);
    EXPECT_FALSE(parse_csv(""));
}

TEST(MarkerTable, EveryBadCellAndRowIsNamed) {
    EXPECT_EQ(parse_csv("a_x,a_y,a_z\n1,x,y\n1,2,3\n1,2,3,4\n?,2,3\n").error().message,
              "line 2: \"x\" in column a_y is not a number; line 2: \"y\" in column a_z is not a number; line 4: 4 columns where the first line has 3; "
              "line 5: \"?\" in column a_x is not a number");
    EXPECT_EQ(parse_csv("frame,a_x,a_y,a_z\n5,1,2,3\n4,1,2,3\n6,1,2,3\n5,1,2,3\n").error().message,
              "column frame: row 1: the time runs back by 1.000; row 3: the time runs back by 1.000");
    std::string many = "1,2,3\n";
    for (int i = 0; i < 30; ++i) many += "1,2,z\n";
    EXPECT_TRUE(parse_csv(many).error().message.ends_with("line 21: \"z\" in column 3 is not a number; and 10 more")) << parse_csv(many).error().message;
}

TEST(MarkerTable, LinesThatEndEarlyAndOtherColumnsAreToldOf) {
    const auto cut = parse_csv("a_x,a_y,a_z,b_x,b_y,b_z\n1,2,3,4,5,6\n1,2,3,4\n");
    ASSERT_TRUE(cut) << cut.error().message;
    ASSERT_EQ(cut->warnings.size(), 1u);
    EXPECT_NE(cut->warnings[0].find("line 3"), std::string::npos) << cut->warnings[0];
    EXPECT_TRUE(cut->points.frame(1).row(1).array().isNaN().all());
    const auto more = parse_csv("frame,a_x,a_y,a_z,speed\n1,1,2,3,4\n");
    ASSERT_TRUE(more) << more.error().message;
    ASSERT_EQ(more->warnings.size(), 1u);
    EXPECT_NE(more->warnings[0].find("speed"), std::string::npos) << more->warnings[0];
}

TEST(Trc, ReadsRateUnitNamesAndBlanks) {
    const auto take = parse_trc("PathFileType\t4\t(X/Y/Z)\ttake.trc\r\n"
                                "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\r\n"
                                "59.94\t59.94\t3\t2\tcm\t59.94\t1\t2\r\nFrame#\tTime\tNose\t\t\tChin\t\t\r\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\r\n\r\n"
                                "1\t0.000\t1.5\t2\t3\t\t\t\r\n2\t0.017\t4\t5\t6\t7\t8\t9\t\r\n3\t0.033\t4\t\t6\t7\tnan\r\n");
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_EQ(take->frame_rate, (Rational{60000, 1001}));
    EXPECT_EQ(take->unit, Unit::cm);
    EXPECT_EQ(take->names, (std::vector<std::string>{"Nose", "Chin"}));
    ASSERT_EQ(take->points.frames, 3);
    EXPECT_EQ(take->partly_missing.text(), "markers 0-1 of frame 2");
    EXPECT_TRUE(take->points.frame(2).array().isNaN().all());
    EXPECT_EQ(take->points.frame(0)(0, 0), 1.5f);
    EXPECT_TRUE(take->points.frame(0).row(1).array().isNaN().all());
    EXPECT_EQ(take->points.frame(1)(1, 2), 9);
    EXPECT_EQ(parse_trc("frame,x\n").error().code, ErrorCode::bad_magic);
    const auto fast = parse_trc("PathFileType\t4\nDataRate\tNumMarkers\n1000000000\t1\nFrame#\tTime\tNose\n\t\tX1\tY1\tZ1\n1\t0\t1\t2\t3\n");
    ASSERT_TRUE(fast) << fast.error().message;
    EXPECT_FALSE(fast->frame_rate) << "nothing films so fast";
    EXPECT_EQ(parse_trc("PathFileType\t4\nNumMarkers\n1\nFrame#\tTime\tNose\n\t\tX1\tY1\tZ1\none\t0\t1\t2\t3\n2\t0\tx\t2\tz\n3\t0\t1\t2\t3\n4\t0\t1\t2\t3\t4\n").error().message,
              "line 6: \"one\" is not a frame number; line 7: \"x\" in column 3 is not a number; line 7: \"z\" in column 5 is not a number; line 9: more than 1 markers");
    EXPECT_EQ(parse_trc("PathFileType\t4\n").error().code, ErrorCode::truncated);
}

/// A C3D file of two points and two frames, written field by field.
Bytes c3d(bool floats, bool dec) {
    const auto bits_of = [&](float value) {
        std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
        if (!dec) return bits;
        if (value == 0) return 0u;
        bits += 2u << 23;  // VAX F: exponent two higher, halves swapped
        return bits >> 16 | bits << 16;
    };
    ByteWriter out;
    const auto f32 = [&](float value) { out.u32(bits_of(value)); };
    const auto pad = [&](std::size_t size) {
        while (out.size() < size) out.u8(0);
    };
    const auto text = [&](std::string_view s) { out.bytes(std::as_bytes(std::span(s))); };
    out.u8(2);      // parameters in block 2
    out.u8(0x50);   // C3D
    out.u16(2);     // points
    out.u16(0);     // analog
    out.u16(1);     // first frame
    out.u16(2);     // last frame
    out.u16(10);    // gap
    f32(floats ? -1.0f : 0.5f);
    out.u16(3);     // frames in block 3
    out.u16(0);
    f32(120);
    pad(512);
    out.u8(1), out.u8(0x50), out.u8(1), out.u8(dec ? 85 : 84);
    out.u8(5), out.u8(0xff), text("POINT"), out.u16(3), out.u8(0);                                                          // group 1
    out.u8(5), out.u8(1), text("UNITS"), out.u16(2 + 1 + 1 + 1 + 2 + 1), out.u8(0xff), out.u8(1), out.u8(2), text("cm"), out.u8(0);
    out.u8(6), out.u8(1), text("LABELS"), out.u16(0), out.u8(0xff), out.u8(2), out.u8(4), out.u8(2), text("NoseChin"), out.u8(0);
    pad(1024);
    for (int frame = 0; frame < 2; ++frame)
        for (int point = 0; point < 2; ++point) {
            const bool missing = frame == 1 && point == 0;
            for (int axis = 0; axis < 3; ++axis) {
                const float value = float(100 * frame + 10 * point + axis);
                if (floats) f32(value);
                else out.u16(static_cast<std::uint16_t>(value * 2));
            }
            if (floats) f32(missing ? -1.0f : 0.0f);
            else out.u16(missing ? 0xffff : 0);
        }
    return out.take();
}

TEST(C3d, ReadsIntegersAndFloatsOfIntelAndDec) {
    for (const bool floats : {false, true})
        for (const bool dec : {false, true}) {
            const auto take = parse_c3d(c3d(floats, dec));
            ASSERT_TRUE(take) << floats << dec << take.error().message;
            EXPECT_EQ(take->unit, Unit::cm);
            EXPECT_EQ(take->frame_rate, (Rational{120, 1}));
            EXPECT_EQ(take->names, (std::vector<std::string>{"Nose", "Chin"}));
            ASSERT_EQ(take->points.frames, 2);
            EXPECT_EQ(take->points.frame(0)(1, 2), 12);
            EXPECT_TRUE(take->points.frame(1).row(0).array().isNaN().all());
            EXPECT_EQ(take->points.frame(1)(1, 1), 111);
        }
}

TEST(C3d, AMarkerThatLacksACoordinateIsMissing) {
    Bytes bytes = c3d(true, false);
    const std::size_t y = 1024 + 16 + 4;  // of the second point of the first frame
    ASSERT_EQ(parse_c3d(bytes)->points.frame(0)(1, 1), 11);
    bytes[y + 2] = std::byte(0xc0), bytes[y + 3] = std::byte(0x7f);
    const auto take = parse_c3d(bytes);
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_TRUE(take->points.frame(0).row(1).array().isNaN().all());
    EXPECT_EQ(take->points.frame(0)(0, 1), 1);
    EXPECT_EQ(take->partly_missing.text(), "marker 1 of frame 0") << "and not that whose residual says so";
}

TEST(C3d, RefusesEveryTruncationAndSurvivesEveryDamagedByte) {
    const Bytes whole = c3d(true, false);
    for (std::size_t n = 0; n < whole.size(); n += n < 20 ? 1 : 7)
        EXPECT_FALSE(parse_c3d(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(n)))) << n;
    for (std::size_t i = 0; i < 700; ++i)
        for (const int value : {0, 255, 128}) {
            Bytes damaged = whole;
            damaged[i] = std::byte(value);
            const auto take = parse_c3d(damaged);
            if (take) {
                EXPECT_LE(take->points.xyz.size(), whole.size());
            }
        }
}

TEST(MarkerTable, ReadsTheOpticalTakes) {
    const auto path = recordings() / "animface_markers/JawMoCap.csv";
    if (recordings().empty() || !std::filesystem::exists(path)) GTEST_SKIP() << "no recordings here";
    const auto take = read_markers(path);
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_EQ(take->points.frames, 1590);
    EXPECT_EQ(take->points.points, 41);
    EXPECT_EQ(take->frame_rate, (Rational{60, 1}));
}

}  // namespace
}  // namespace mien::io
