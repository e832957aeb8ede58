#include "io/clip_folder.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/environment_error.hpp"
#include "io/clip_check.hpp"
#include "io/file.hpp"
#include "io/image_file.hpp"
#include "io/npy.hpp"
#include "io/obj.hpp"
#include "io/sound_file.hpp"
#include "small_clip.hpp"
#include "tests/recordings.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

using namespace test;
using tests::recordings;
using tests::TemporaryFolder;

namespace fs = std::filesystem;

TEST(ClipFolder, ComesBackAsItWasWritten) {
    const TemporaryFolder folder;
    const Clip clip = full_clip();
    ASSERT_TRUE(write_clip(folder / "take", clip));
    const auto loaded = load_clip(folder / "take");
    ASSERT_TRUE(loaded) << loaded.error().message;
    for (const std::string& warning : loaded->warnings) ADD_FAILURE() << warning;
    const Clip& back = loaded->clip;
    EXPECT_EQ(back.name, "take");
    EXPECT_EQ(back.frame_rate, clip.frame_rate);
    EXPECT_EQ(back.unit, Unit::cm);
    EXPECT_TRUE(back.neutral->positions.isApprox(clip.neutral->positions, 1e-6f));
    EXPECT_EQ(back.neutral->triangles, clip.neutral->triangles);
    for (int f = 0; f < 3; ++f) {
        EXPECT_TRUE(back.vertices->frame(f).isApprox(clip.vertices->frame(f), 1e-6f));
        EXPECT_TRUE(back.head_pose[std::size_t(f)].rotation.isApprox(clip.head_pose[std::size_t(f)].rotation, 1e-6f));
        EXPECT_TRUE(back.head_pose[std::size_t(f)].translation.isApprox(clip.head_pose[std::size_t(f)].translation, 1e-6f));
        EXPECT_EQ(back.gaze[std::size_t(f)].yaw[1], 0.2f);
        EXPECT_EQ(back.gaze[std::size_t(f)].pitch[1], clip.gaze[std::size_t(f)].pitch[1]);
        EXPECT_EQ(back.texture->read(f)->pixels, clip.texture->read(f)->pixels);
    }
    EXPECT_TRUE(back.markers->frame(1).row(0).array().isNaN().all());
    EXPECT_NEAR(back.markers->frame(2)(0, 2), 2, 1e-6);
    EXPECT_EQ(back.weights->values, clip.weights->values);
    EXPECT_EQ(back.weights->names, clip.weights->names);
    ASSERT_EQ(back.marker_sites.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_TRUE(back.marker_sites[i].position(clip.neutral->positions).isApprox(clip.marker_sites[i].position(clip.neutral->positions), 1e-5f));
    ASSERT_EQ(back.blendshapes.size(), 2u);
    EXPECT_EQ(back.blendshapes[1].name, "Smile");
    EXPECT_TRUE(back.blendshapes[1].offsets.isApprox(clip.blendshapes[1].offsets, 1e-6f));
    EXPECT_EQ(back.rigid, clip.rigid);
    EXPECT_EQ(back.mask->pixels, clip.mask->pixels);
    EXPECT_EQ(back.sound->length(), 4805);
    EXPECT_NEAR(back.sound->samples[7], 0.5f, 1e-4f);

    const ClipReport report = check_clip(folder / "take");
    EXPECT_TRUE(report.good()) << report.text();
    EXPECT_EQ(report.frames, 3);
    EXPECT_NEAR(report.markers_present, 5.0 / 6, 1e-9);
    EXPECT_NE(report.json().find("\"fps\": \"30000/1001\""), std::string::npos);
}

TEST(ClipFolder, IsNeverOverwrittenUnasked) {
    const TemporaryFolder folder;
    Clip clip = full_clip();
    ASSERT_TRUE(write_clip(folder / "take", clip));
    write_file(folder / "take" / "notes.txt", "mine");
    EXPECT_THROW((void)write_clip(folder / "take", clip), EnvironmentError);
    clip.frame_rate = {60, 1};
    clip.sound.reset();
    ASSERT_TRUE(write_clip(folder / "take", clip, {.overwrite = true}));
    EXPECT_EQ(load_clip(folder / "take")->clip.frame_rate, (Rational{60, 1}));
    EXPECT_FALSE(load_clip(folder / "take")->clip.sound);
    EXPECT_EQ(read_text(folder / "take" / "notes.txt").value(), "mine");
    // Nothing else is left lying about.
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
    write_file(folder / "file", "x");
    EXPECT_THROW((void)write_clip(folder / "file", clip), EnvironmentError);
    EXPECT_THROW((void)write_clip("/proc/nowhere/clip", clip), EnvironmentError);
}

TEST(ClipFolder, AFullDiskIsToldAndLeavesNothing) {
    const TemporaryFolder folder;
    // A limit on file sizes answers as a full disk does.
    rlimit before{}, small{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = {10'000, before.rlim_max};
    const auto handler = signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_THROW(write_npy(folder / "a.npy", {100000}, std::vector<float>(100000)), EnvironmentError);
    EXPECT_THROW(write_file(folder / "a.txt", std::string(10'001, 'a')), EnvironmentError) << "shows only when the file is closed";
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, handler);
    EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(ClipFolder, AFileOfTheSameNameThatComesMeanwhileStays) {
    const TemporaryFolder folder;
    OutputFile first(folder / "a.mien", false), second(folder / "a.mien", false), third(folder / "a.mien", true);
    write_file(folder / "a.mien.part", "somebody else's");
    first.write("first");
    second.write("second");
    third.write("third");
    first.commit();
    EXPECT_THROW(second.commit(), EnvironmentError);
    EXPECT_EQ(read_text(folder / "a.mien").value(), "first");
    third.commit_to_disk();
    EXPECT_EQ(read_text(folder / "a.mien").value(), "third");
    EXPECT_EQ(read_text(folder / "a.mien.part").value(), "somebody else's");
}

TEST(ClipFolder, OfTwoThatAreWrittenAtOnceOneIsKeptWhole) {
    const TemporaryFolder folder;
    Clip clip = full_clip(), other = full_clip();
    std::atomic<bool> written = false;
    // The other writer is done when this one has come to its texture.
    const auto meanwhile = [&](std::string_view, std::int64_t, std::int64_t) {
        if (written.exchange(true)) return;
        EXPECT_TRUE(write_clip(folder / "take", other));
    };
    other.frame_rate = {60, 1};
    EXPECT_THROW((void)write_clip(folder / "take", clip, {.progress = meanwhile}), EnvironmentError);
    const auto loaded = load_clip(folder / "take");
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->clip.frame_rate, (Rational{60, 1}));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1) << "nothing is left beside it";
}

TEST(ClipFolder, AMovingTextureCanBeOneLosslessVideo) {
    const TemporaryFolder folder;
    const Clip clip = full_clip();
    ASSERT_TRUE(write_clip(folder / "take", clip, {.texture_video = true}));
    EXPECT_TRUE(fs::exists(folder / "take" / "texture.mkv"));
    EXPECT_FALSE(fs::exists(folder / "take" / "texture"));
    const auto loaded = load_clip(folder / "take");
    ASSERT_TRUE(loaded) << loaded.error().message;
    ASSERT_EQ(loaded->clip.texture->frames(), 3);
    for (int f = 0; f < 3; ++f) EXPECT_EQ(loaded->clip.texture->read(f)->pixels, clip.texture->read(f)->pixels);
}

TEST(ClipFolder, ItsDescriptionStaysReadable) {
    const TemporaryFolder folder;
    Clip clip = full_clip();
    ASSERT_TRUE(write_clip(folder / "take", clip));
    const std::string text = read_text(folder / "take" / "clip.json").value();
    for (const char* line : {"{\n  \"fps\": \"30000/1001\",\n", "\n  \"rigid\": \"rigid.npy\",\n", "\n  \"weight_names\": [\"JawOpen\",\"Smile\"],\n"})
        EXPECT_NE(text.find(line), std::string::npos) << text;
    EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 20);
    // Sites at vertices alone are one column.
    clip.marker_sites = {Site::at_vertex(3), Site::at_vertex(1)};
    ASSERT_TRUE(write_clip(folder / "take", clip, {.overwrite = true}));
    EXPECT_EQ(read_npy_shape(folder / "take" / "marker_sites.npy").value(), std::vector<std::int64_t>{2});
    EXPECT_EQ(load_clip(folder / "take")->clip.marker_sites[1].vertices[2], 1u);
}

TEST(ClipFolder, WhatAKilledProcessLeftIsClearedAway) {
    const TemporaryFolder folder;
    const pid_t child = fork();
    if (child == 0) _exit(0);
    ASSERT_EQ(waitpid(child, nullptr, 0), child);  // so nobody has this number now
    const fs::path dead = folder / (".take.part-" + std::to_string(child)), alive = folder / ".take.part-1",
                   other = folder / (".take2.part-" + std::to_string(child));
    for (const fs::path& path : {dead, alive, other}) fs::create_directory(path);
    ASSERT_TRUE(write_clip(folder / "take", full_clip()));
    EXPECT_FALSE(fs::exists(dead));
    EXPECT_TRUE(fs::exists(alive));
    EXPECT_TRUE(fs::exists(other));
}

TEST(ClipFolder, APatternNamesItsNumberInThreeWays) {
    const TemporaryFolder folder;
    const Mesh mesh = small_head();
    write_obj(folder / "neutral.obj", mesh);
    for (int f = 9; f < 12; ++f) {
        write_obj(folder / ("frame" + std::to_string(f) + ".obj"), mesh);
        write_image(folder / ("skin" + std::to_string(f) + "_a.png"), Image(8, 8, 3));
    }
    const auto load = [&](const std::string& number) {
        write_file(folder / "clip.json", R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "vertices": "frame)" + number + R"(.obj", "texture": "skin)" + number + R"(_a.png"})");
        return load_clip(folder.path());
    };
    for (const char* number : {"%d", "%02d", "#", "####", "*"}) {
        const auto loaded = load(number);
        ASSERT_TRUE(loaded) << number << ": " << loaded.error().message;
        EXPECT_EQ(loaded->clip.vertices->frames, 3) << number;
        EXPECT_EQ(loaded->clip.texture->frames(), 3) << number;
    }
    for (const char* number : {"%", "%s", "%02", "0*", "*1"}) EXPECT_FALSE(load(number)) << number;
}

TEST(PlainFolder, NumberedMeshesWithOnePictureLoadAsTheyStand) {
    const TemporaryFolder folder;
    Mesh mesh = small_head();
    for (int f = 9; f < 12; ++f) {  // numbers that sort wrongly as text
        mesh.positions(0, 0) = float(f);
        write_obj(folder / ("frame" + std::to_string(f) + ".obj"), mesh, 10);
    }
    Image picture(8, 8, 4);
    write_image(folder / "skin.png", picture);
    write_wav(folder / "voice.wav", {48000, 2, std::vector<float>(9600)});
    const auto loaded = load_clip(folder.path());
    ASSERT_TRUE(loaded) << loaded.error().message;
    const Clip& clip = loaded->clip;
    ASSERT_TRUE(clip.vertices);
    EXPECT_EQ(clip.vertices->frames, 3);
    EXPECT_EQ(clip.unit, Unit::cm);
    for (int f = 0; f < 3; ++f) EXPECT_NEAR(clip.vertices->frame(f)(0, 0), 9 + f, 1e-5);
    EXPECT_EQ(clip.frame_rate, (Rational{30, 1}));
    EXPECT_EQ(clip.neutral->triangles.size(), 4u);
    ASSERT_TRUE(clip.texture);
    EXPECT_EQ(clip.texture->frames(), 1);
    EXPECT_EQ(clip.texture->read(0)->channels, 3);
    EXPECT_EQ(clip.sound->channels, 2);
    EXPECT_TRUE(warns(*loaded, "\"fps\""));
    EXPECT_TRUE(warns(*loaded, "\"unit\""));
    EXPECT_TRUE(warns(*loaded, "alpha"));

    fs::remove(folder / "frame10.obj");
    expect_message(folder.path(), {"10", "missing"});
    write_file(folder / "frame10.obj", "v 0 0 0\nv 1 1 1\n");
    expect_message(folder.path(), {"frame10.obj", "frame 1", "2 vertices"});
}

TEST(PlainFile, ASingleRecordingLoads) {
    const TemporaryFolder folder;
    write_file(folder / "take.csv", "time,a_x,a_y,a_z,b_x,b_y,b_z,c_x,c_y,c_z,d_x,d_y,d_z\n0,0,0,0,15,0,0,0,15,0,0,0,1\n0.04,0,0,0,15,0,0,0,15,0,0,0,2\n");
    const auto markers = load_clip(folder / "take.csv");
    ASSERT_TRUE(markers) << markers.error().message;
    EXPECT_EQ(markers->clip.name, "take");
    EXPECT_EQ(markers->clip.frame_rate, (Rational{25, 1}));
    EXPECT_EQ(markers->clip.unit, Unit::cm);
    EXPECT_EQ(markers->clip.markers->frame(1)(3, 2), 20);
    write_npy(folder / "w.npy", {2, 5}, std::vector<float>(10));
    EXPECT_EQ(load_clip(folder / "w.npy")->clip.weights->count, 5);
    write_obj(folder / "head.obj", small_head());
    EXPECT_EQ(load_clip(folder / "head.obj")->clip.vertices->frames, 1);
    expect_message(folder / "none.npy", {"none.npy"});
}

TEST(PlainFile, AMarkerThatLacksACoordinateIsMissingWhateverTheFile) {
    const TemporaryFolder folder;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    write_npy(folder / "m.npy", {3, 2, 3}, std::vector<float>{0, 0, 0, 100, 0, nan, 0, 0, 0, nan, nan, 0, 0, 0, 0, nan, nan, nan});
    write_file(folder / "m.csv", "a_x,a_y,a_z,b_x,b_y,b_z\n0,0,0,100,0,\n0,0,0,nan,,0\n0,0,0,,,\n");
    for (const char* name : {"m.npy", "m.csv"}) {
        const auto loaded = load_clip(folder / name);
        ASSERT_TRUE(loaded) << loaded.error().message;
        for (int f = 0; f < 3; ++f) {
            EXPECT_TRUE(loaded->clip.markers->frame(f).row(1).array().isNaN().all()) << name << f;
            EXPECT_TRUE(loaded->clip.markers->frame(f).row(0).isZero()) << name << f;
        }
        EXPECT_TRUE(warns(*loaded, "2 times a marker lacks one or two of its coordinates, and is missing in that frame: marker 1 of frames 0-1")) << name;
        EXPECT_NE(check_clip(folder / name).json().find("marker 1 of frames 0-1"), std::string::npos);
    }
}

TEST(PlainFile, ToldWhatItLacksByWhatCanBeDone) {
    const TemporaryFolder folder;
    write_npy(folder / "m.npy", {2, 1, 3}, std::vector<float>(6));
    const auto alone = load_clip(folder / "m.npy");
    ASSERT_TRUE(alone) << alone.error().message;
    EXPECT_TRUE(warns(*alone, "give --fps") && warns(*alone, "give --unit"));
    write_file(folder / "clip.json", "{}");
    EXPECT_TRUE(warns(*load_clip(folder / "m.npy"), "name the folder"));
}

TEST(PlainFolder, WeightsAmongWhichSomeAreNamedAsAxesStayWeights) {
    const std::string table = "time_s,jawOpen,smile,grp_x,grp_y,grp_z\n0,0,1,2,3,4\n0.1,0,1,2,3,4\n";
    for (const char* name : {"weights.csv", "take.csv"}) {
        const TemporaryFolder folder;
        write_file(folder / name, table);
        const auto loaded = load_clip(folder.path());
        ASSERT_TRUE(loaded) << loaded.error().message;
        ASSERT_TRUE(loaded->clip.weights) << name;
        EXPECT_EQ(loaded->clip.weights->count, 5);
        EXPECT_FALSE(loaded->clip.markers);
    }
    const TemporaryFolder folder;
    write_file(folder / "markers.csv", table);
    const auto loaded = load_clip(folder.path());
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->clip.markers->points, 1);
    EXPECT_TRUE(warns(*loaded, "jawOpen, smile"));
}

TEST(PlainFolder, AModelBesideARecordingIsItsNeutralOrNamed) {
    if (recordings().empty()) GTEST_SKIP() << "no recordings here";
    const auto loaded = load_clip(recordings() / "facecap_glb");
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->clip.weights->count, 67);
    EXPECT_TRUE(warns(*loaded, "facecap.glb"));
}

TEST(Recordings, ReadyClipsLoad) {
    const fs::path clips = recordings() / "clips";
    if (recordings().empty() || !fs::exists(clips)) GTEST_SKIP() << "no recordings here";
    for (const auto& [name, frames, points] : std::initializer_list<std::tuple<const char*, std::int64_t, std::int64_t>>{
             {"ict_182_markers", 4030, 182}, {"optical_41_jaw", 1590, 41}, {"optical_41_cheeks", 1499, 41}}) {
        const auto loaded = load_clip(clips / name);
        ASSERT_TRUE(loaded) << loaded.error().message;
        EXPECT_EQ(loaded->clip.name, name);
        EXPECT_EQ(loaded->clip.frame_count(), frames);
        EXPECT_EQ(loaded->clip.markers->points, points);
        EXPECT_TRUE(loaded->warnings.empty()) << loaded->warnings[0];
    }
    const auto speech = load_clip(clips / "arkit_52_speech");
    ASSERT_TRUE(speech) << speech.error().message;
    EXPECT_EQ(speech->clip.frame_rate, (Rational{60000, 1001}));
    EXPECT_EQ(speech->clip.weights->frames, 1218);
    EXPECT_EQ(speech->clip.weights->count, 52);
    const auto take = load_clip(recordings() / "livelinkface/alex_rom_3.csv");
    ASSERT_TRUE(take) << take.error().message;
    EXPECT_TRUE(warns(*take, "3 dropped frames"));
}

}  // namespace
}  // namespace mien::io
