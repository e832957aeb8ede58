#include "samples/stage.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/environment_error.hpp"
#include "io/clip_folder.hpp"
#include "io/file.hpp"
#include "io/sound_file.hpp"
#include "samples/skin.hpp"
#include "samples/speech.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::samples {
namespace {

using tests::TemporaryFolder;

/// A take at 60 Hz: frame f has JawOpen f / 100; frame 3 was dropped. The head turns to the right, the eyes look down.
std::string take() {
    std::string csv = "Timecode,BlendShapeCount,";
    for (std::string_view name : kArkitNames) csv += fmt::format("{},", name);
    csv += "HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,RightEyePitch,RightEyeRoll\n";
    for (int f : {0, 1, 2, 4, 5, 6, 7, 8, 9}) {
        csv += fmt::format("10:00:00:{:02}.000,61,", f);
        for (int i = 0; i < kArkitCount; ++i) csv += i == arkit_index("JawOpen") ? fmt::format("{},", f / 100.0) : "0,";
        csv += "0.3,0,0,0.1,0.2,0,0.1,0.2,0\n";
    }
    return csv;
}

TEST(LiveTake, FillsDroppedFramesAndTurnsHeadAndEyes) {
    const TemporaryFolder folder;
    io::write_file(folder / "take.csv", std::string_view(take()));
    const auto p = perform_take(folder / "take.csv");
    ASSERT_TRUE(p.ok()) << p.error().message;
    ASSERT_EQ(p->frames(), 10);
    const auto jaw = std::size_t(arkit_index("JawOpen"));
    for (std::size_t f = 0; f < 10; ++f) EXPECT_NEAR(p->instants[f].weights[jaw], float(f) / 100, 1e-6f);
    const Instant& one = p->instants[5];
    EXPECT_LT((one.head.rotation * Vec3::UnitZ()).x(), -0.2f);  // the nose points to the actor's right
    EXPECT_NEAR(one.gaze.yaw[0], -0.1f, 1e-3f);
    EXPECT_NEAR(one.gaze.pitch[1], -0.2f, 1e-3f);
}

TEST(LiveTake, CutsPictureAndSoundTogether) {
    const TemporaryFolder folder;
    io::write_file(folder / "take.csv", std::string_view(take()));
    Sound ramp{6000, 1, {}};
    for (int n = 0; n < 1000; ++n) ramp.samples.push_back(float(n) / 2000);
    io::write_wav(folder / "take.wav", ramp);
    const auto whole = perform_take(folder / "take.csv", folder / "take.wav");
    ASSERT_TRUE(whole.ok()) << whole.error().message;
    const auto p = cut(*whole, {4, 8});
    ASSERT_TRUE(p.ok()) << p.error().message;
    EXPECT_EQ(p->frames(), 4);
    EXPECT_NEAR(p->instants[0].weights[std::size_t(arkit_index("JawOpen"))], 0.04f, 1e-6f);
    ASSERT_NEAR(double(p->sound->length()), 400, 2);
    EXPECT_NEAR(p->sound->samples[0], 0.2f, 2e-3f);
    for (const FrameRange outside : {FrameRange{4, 11}, {4, 4}, {-1, 3}}) EXPECT_EQ(cut(*whole, outside).error().code, ErrorCode::invalid);
    EXPECT_EQ(perform_take(folder / "none.csv").error().code, ErrorCode::missing);
}

StageOptions small() {
    StageOptions options;
    options.expressions = true;
    options.seconds = 0.2;
    options.markers = 60;
    options.texture_size = 32;
    return options;
}

TEST(Stage, FramesArePartsOfAnyPerformance) {
    StageOptions options = small();
    const auto whole = make_performance(options);
    options.frames = FrameRange{2, 5};
    const auto part = make_performance(options);
    ASSERT_TRUE(whole.ok() && part.ok());
    ASSERT_EQ(part->frames(), 3);
    for (std::size_t f = 0; f < 3; ++f) EXPECT_EQ(part->instants[f].weights, whole->instants[f + 2].weights);
    if (!can_speak()) return;
    options = {};
    options.say = "Hello";
    options.frames = FrameRange{3, 9};
    const auto spoken = make_performance(options);
    ASSERT_TRUE(spoken.ok()) << spoken.error().message;
    EXPECT_EQ(spoken->frames(), 6);
    EXPECT_NEAR(double(spoken->sound->length()), 0.2 * spoken->sound->sample_rate, 1);
}

TEST(Stage, WritesAClipThatReadsBackWhole) {
    const TemporaryFolder folder;
    StageOptions options = small();
    options.fps = make_rational(30000, 1001);
    options.noise = 0.1;
    const auto made = stage(options, folder / "clip");
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto loaded = io::load_clip(folder / "clip");
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    EXPECT_TRUE(loaded->warnings.empty()) << loaded->warnings[0];
    const Clip& clip = loaded->clip;
    EXPECT_EQ(clip.frame_rate, make_rational(30000, 1001));
    EXPECT_EQ(clip.frame_count(), 6);
    EXPECT_EQ(clip.markers->points, 60);
    EXPECT_EQ(clip.marker_sites.size(), 60u);
    EXPECT_EQ(clip.weights->count, kArkitCount);
    EXPECT_EQ(clip.head_pose.size(), 6u);
    EXPECT_EQ(clip.gaze.size(), 6u);
    EXPECT_FALSE(clip.rigid.empty());
    EXPECT_TRUE(clip.blendshapes.empty());
    ASSERT_TRUE(clip.texture);
    EXPECT_EQ(clip.texture->frames(), 6);
    ASSERT_TRUE(clip.mask);

    // The truth: vertices are the actor's, turned by the pose; the texture is what the skin painted, to the bit.
    const auto actor = make_actor(options);
    const auto performance = make_performance(options);
    ASSERT_TRUE(actor.ok() && performance.ok());
    Points expected = (*actor)->deform(performance->instants[4]);
    apply_pose(performance->instants[4].head, expected);
    EXPECT_LT((expected - clip.vertices->frame(4)).cwiseAbs().maxCoeff(), 1e-4f);
    const Skin skin(**actor, 32, options.seed);
    const auto picture = clip.texture->read(4);
    ASSERT_TRUE(picture.ok()) << picture.error().message;
    EXPECT_EQ(picture->pixels, skin.texture(performance->instants[4], (*actor)->deform(performance->instants[4])).pixels);
}

TEST(Stage, NeverOverwritesUnlessForced) {
    const TemporaryFolder folder;
    StageOptions options = small();
    options.texture_size = 0;
    std::filesystem::create_directory(folder / "clip");
    io::write_file(folder / "clip" / "mine.txt", std::string_view("precious"));
    EXPECT_THROW((void)stage(options, folder / "clip"), EnvironmentError);
    options.force = true;
    const auto made = stage(options, folder / "clip");
    ASSERT_TRUE(made.ok()) << made.error().message;
    EXPECT_EQ(*io::read_text(folder / "clip" / "mine.txt"), "precious");
    EXPECT_TRUE(io::load_clip(folder / "clip").ok());
}

TEST(Stage, RefusesOptionsThatMakeNoSense) {
    const auto refused = [](auto change) {
        StageOptions options = small();
        change(options);
        const auto made = stage(options, "never-written");
        return !made.ok() && made.error().code == ErrorCode::invalid && !std::filesystem::exists("never-written");
    };
    EXPECT_TRUE(refused([](StageOptions& o) { o.say = "hello"; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.frames = FrameRange{0, 7}; })) << "of six frames";
    EXPECT_TRUE(refused([](StageOptions& o) { o.expressions = false, o.seconds = {}, o.session = "training", o.frames = FrameRange{0, 5}; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.actor = "nobody"; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.seconds = -1; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.noise = -0.5; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.texture_size = 5; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.fps = Rational{0, 1}; }));
    EXPECT_TRUE(refused([](StageOptions& o) { o.identity = {1}; }));
    for (const float far : {1e10f, -11.f, NAN})
        EXPECT_TRUE(refused([&](StageOptions& o) { o.actor = "ict:nowhere", o.identity = {0, far}; }));
}

TEST(Stage, SpeaksForAboutTenSecondsWhenNotTold) {
    const auto p = make_performance({});
    ASSERT_TRUE(p.ok()) << p.error().message;
    if (!can_speak()) GTEST_SKIP() << "skipped: this build cannot speak";
    EXPECT_GT(p->seconds(), 9);
    EXPECT_LT(p->seconds(), 12);
    EXPECT_TRUE(p->sound);
}

}  // namespace
}  // namespace mien::samples
