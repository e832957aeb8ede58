#include "io/live_link.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/recordings.hpp"

namespace mien::io {
namespace {

using tests::recordings;

const std::string kHeader = "Timecode,BlendShapeCount,JawOpen,MouthClose,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,"
                            "RightEyePitch,RightEyeRoll\r\n";

std::string row(const std::string& time, double jaw) {
    return time + ",61," + std::to_string(jaw) + ",0.5,0.1,0.2,0.3,0.01,0.02,0,-0.03,0.04,0\r\n";
}

TEST(LiveLink, DroppedFramesAreFoundFromTheTimecodeAndFilled) {
    // Every second tick of 60: 30 Hz. The frames at 04.0 and 06.0 were dropped.
    const auto take = parse_live_link("\xef\xbb\xbf" + kHeader + row("23:59:59:56.001", 0.1) + row("23:59:59:58.000", 0.2) + row("00:00:00:00.000", 0.3) +
                                      row("00:00:00:02.001", 0.3) + row("00:00:00:08.000", 0.6) + row("00:00:00:10.000", 0.6));
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_EQ(take->frame_rate, (Rational{30, 1}));
    EXPECT_EQ(take->rows, 6);
    EXPECT_EQ(take->weights.frames, 8);
    EXPECT_EQ(take->weights.names, (std::vector<std::string>{"JawOpen", "MouthClose"}));
    EXPECT_EQ(take->dropped, (std::vector<std::int64_t>{4, 5}));
    const float jaw[] = {0.1f, 0.2f, 0.3f, 0.3f, 0.4f, 0.5f, 0.6f, 0.6f};
    for (int f = 0; f < 8; ++f) EXPECT_NEAR(take->weights.frame(f)[0], jaw[f], 1e-6) << f;
    ASSERT_EQ(take->gaze.size(), 8u);
    EXPECT_FLOAT_EQ(take->gaze[0].yaw[0], 0.03f);  // the right eye
    EXPECT_FLOAT_EQ(take->gaze[0].pitch[0], -0.04f);
    EXPECT_FLOAT_EQ(take->gaze[0].yaw[1], -0.01f);
    // Positive yaw turns the face to the actor's right, positive pitch lowers it.
    const Vec3 nose = take->head_pose[0].rotation * Vec3(0, 0, 1);
    EXPECT_LT(nose.x(), -0.05f);
    EXPECT_LT(nose.y(), -0.1f);
}

TEST(LiveLink, ReadsNtscRates) {
    std::string text = kHeader;
    double tick = 0;
    for (int i = 0; i < 200; ++i, tick += 1.0016) {
        char time[32];
        std::snprintf(time, sizeof time, "10:00:%02d:%06.3f", int(tick / 60), std::fmod(tick, 60));
        text += row(time, 0);
    }
    const auto take = parse_live_link(text);
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_EQ(take->frame_rate, (Rational{60000, 1001}));
    EXPECT_EQ(take->weights.frames, 200);
    EXPECT_TRUE(take->dropped.empty());
}

TEST(LiveLink, RefusesNonsenseByLine) {
    const auto message = [](const std::string& rows) {
        const auto take = parse_live_link(kHeader + rows);
        EXPECT_FALSE(take) << rows;
        return take ? "" : take.error().message;
    };
    EXPECT_NE(message("10:00:00:00.0,61,0.1\n").find("line 2"), std::string::npos);
    EXPECT_NE(message(row("10:00:00:00.0", 0) + row("10:61:00:00.0", 0)).find("line 3"), std::string::npos);
    EXPECT_NE(message(row("10:00:00:02.0", 0) + row("10:00:00:01.0", 0)).find("line 3"), std::string::npos);
    EXPECT_NE(message(row("10:00:00:00.0", 0) + row("10:00:30:01.0", 0)).find("jumps"), std::string::npos);
    EXPECT_NE(message(row("10:00:00:00.0", NAN)).find("JawOpen"), std::string::npos);
    // Two ticks a frame: the row of line 4 is frame 2, one frame after it was dropped.
    const std::string bad = message(row("10:00:00:00.0", 0) + row("10:00:00:02.0", 0) + row("10:00:00:04.0", NAN) + row("10:00:00:08.0", INFINITY) +
                                    "10:00:00:10.0,61,0,x,0.1,0.2,nan,0,0,0,0,0,0\r\n");
    EXPECT_EQ(bad, "line 4: not a finite number: weight 0 (JawOpen) of frames 2, 4; weight 1 (MouthClose) of frame 5; angle 2 (headroll) of frame 5");
    EXPECT_NE(message("").find("no frames"), std::string::npos);
    // What is wrong with some rows hides nothing of the others.
    EXPECT_EQ(message(row("10:00:00:00.0", 0) + "10:00:00:02.0,61\n" + row("10:00:00:04.0", NAN) + row("soon", 0) + row("10:00:00:08.0", 0)),
              "line 4: not a finite number: weight 0 (JawOpen) of frame 1; line 3: 2 columns where the header has 13; line 5: \"soon\" is no timecode HH:MM:SS:FF.sss");
    EXPECT_EQ(message(row("10:00:00:00.0", 0) + row("10:00:30:00.0", 0) + "10:00:30:02.0\n" + row("10:00:10:00.0", 0)),
              "line 4: 1 columns where the header has 13; line 3: the timecode jumps by 30.00 s; line 5: the timecode jumps by -20.00 s");
    EXPECT_NE(message("1\n2\n").find("line 3"), std::string::npos);
    EXPECT_EQ(parse_live_link("a,b,c\n1,2,3\n").error().code, ErrorCode::bad_magic);
    EXPECT_FALSE(parse_live_link(""));
}

TEST(LiveLink, ReadsRealTakes) {
    const auto folder = recordings() / "livelinkface";
    if (recordings().empty() || !std::filesystem::exists(folder / "alex_rom_3.csv")) GTEST_SKIP() << "no recordings here";
    const auto alex = read_live_link(folder / "alex_rom_3.csv");
    ASSERT_TRUE(alex) << alex.error().message;
    EXPECT_EQ(alex->rows, 4030);
    EXPECT_EQ(alex->weights.count, 52);
    EXPECT_EQ(alex->frame_rate, (Rational{30, 1}));
    EXPECT_EQ(alex->dropped, (std::vector<std::int64_t>{596, 2126, 3621}));
    EXPECT_EQ(alex->weights.frames, 4033);

    // ARKit's own weights tell where the eyes look: the signs of the angles must agree.
    double yaw = 0, pitch = 0;
    for (std::int64_t f = 0; f < alex->weights.frames; ++f) {
        const float* w = alex->weights.frame(f);
        const Gaze& gaze = alex->gaze[std::size_t(f)];
        yaw += gaze.yaw[1] * (w[3] - w[2]);    // EyeLookOutLeft - EyeLookInLeft: the left eye to the left
        pitch += gaze.pitch[1] * (w[4] - w[1]);  // EyeLookUpLeft - EyeLookDownLeft
    }
    EXPECT_GT(yaw, 0);
    EXPECT_GT(pitch, 0);

    const auto speech = read_live_link(folder / "neurosync_testset.csv");
    ASSERT_TRUE(speech) << speech.error().message;
    EXPECT_EQ(speech->frame_rate, (Rational{60000, 1001}));
    EXPECT_EQ(speech->weights.frames, 1218);
    EXPECT_TRUE(speech->dropped.empty());
}

}  // namespace
}  // namespace mien::io
