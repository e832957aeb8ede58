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
#include "io/texture_file.hpp"
#include "tests/recordings.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

using tests::recordings;
using tests::TemporaryFolder;

namespace fs = std::filesystem;

/// A tetrahedron the size of a head.
Mesh small_head() {
    Mesh mesh;
    mesh.positions.resize(4, 3);
    mesh.positions << 0, 0, 0, 200, 0, 0, 0, 250, 0, 0, 0, 200;
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

/// Everything a clip can have, 3 frames.
Clip full_clip() {
    Clip clip;
    clip.frame_rate = {30000, 1001};
    clip.unit = Unit::cm;
    clip.neutral = small_head();
    clip.vertices.emplace(3, 4);
    clip.markers.emplace(3, 2);
    clip.weights.emplace(3, 2);
    clip.weights->names = {"JawOpen", "Smile"};
    for (int f = 0; f < 3; ++f) {
        clip.vertices->frame(f) = clip.neutral->positions.array() + float(f);
        clip.markers->frame(f) << 1, 2, float(f), 4, 5, 6;
        clip.weights->frame(f)[0] = 0.25f * float(f);
        clip.head_pose.push_back({Eigen::Quaternionf(Eigen::AngleAxisf(0.1f * float(f), Vec3::UnitY())), Vec3(float(f), 2, 3)});
        clip.gaze.push_back({{0.1f, 0.2f}, {0.3f, 0.1f * float(f)}});
    }
    clip.markers->frame(1).row(0).setConstant(std::numeric_limits<float>::quiet_NaN());
    clip.marker_sites = {Site::at_vertex(2), {{3, 0, 1}, {0.5f, 0.25f, 0.25f}}};
    clip.blendshapes = {{"JawOpen", Points::Constant(4, 3, 1)}, {"Smile", Points::Constant(4, 3, -2)}};
    clip.rigid = {0, 3};
    std::vector<Image> frames(3, Image(5, 3, 3));
    for (int f = 0; f < 3; ++f) frames[std::size_t(f)].pixels.assign(45, std::uint8_t(50 * f));
    clip.texture = texture_of(std::move(frames));
    clip.mask = Image(5, 3, 1);
    clip.mask->pixels.assign(15, 255);
    clip.sound.emplace();
    clip.sound->samples.assign(4805, 0.5f);
    return clip;
}

void expect_message(const fs::path& path, std::initializer_list<const char*> words) {
    const auto loaded = load_clip(path);
    ASSERT_FALSE(loaded) << "loaded what should have been refused for " << *words.begin();
    for (const char* word : words) EXPECT_NE(loaded.error().message.find(word), std::string::npos) << loaded.error().message;
}

bool warns(const LoadedClip& loaded, const char* word) {
    for (const std::string& warning : loaded.warnings)
        if (warning.find(word) != std::string::npos) return true;
    return false;
}

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

class BadClip : public ::testing::Test {
protected:
    BadClip() {
        clip = full_clip();
        EXPECT_TRUE(write_clip(path, clip));
    }
    void describe(const std::string& json) { write_file(path / "clip.json", json); }

    TemporaryFolder folder;
    fs::path path = folder / "take";
    Clip clip;
};

TEST_F(BadClip, NonFiniteValuesAreNamedByFrameAndPoint) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    std::vector<float> xyz(3 * 4 * 3, 1);
    xyz[(2 * 4 + 3) * 3 + 1] = nan;
    write_npy(path / "vertices.npy", {3, 4, 3}, xyz);
    expect_message(path, {"vertices.npy", "vertex 3", "frame 2", "not a number"});
    xyz[(2 * 4 + 3) * 3 + 1] = infinity;
    write_npy(path / "vertices.npy", {3, 4, 3}, xyz);
    expect_message(path, {"vertices.npy", "vertex 3", "frame 2", "infinite"});
    write_clip(path, clip, {.overwrite = true}).ok();
    std::vector<float> weights(6);
    weights[3] = nan;
    write_npy(path / "weights.npy", {3, 2}, weights);
    expect_message(path, {"weights.npy", "weight 1 (Smile)", "frame 1"});
    write_clip(path, clip, {.overwrite = true}).ok();
    std::vector<float> markers(18, 1);
    markers[0] = -infinity;
    write_npy(path / "markers.npy", {3, 2, 3}, markers);
    expect_message(path, {"markers.npy", "marker 0", "frame 0", "infinite"});
}

TEST_F(BadClip, DisagreementsAreNamed) {
    write_npy(path / "markers.npy", {2, 2, 3}, std::vector<float>(12, 1));
    expect_message(path, {"markers.npy has 2 frames", "vertices.npy has 3"});
    write_npy(path / "markers.npy", {3, 5, 3}, std::vector<float>(45, 1));
    expect_message(path, {"marker_sites has 2 entries", "5 markers"});
    write_clip(path, clip, {.overwrite = true}).ok();
    write_npy(path / "vertices.npy", {3, 5, 3}, std::vector<float>(45, 1));
    expect_message(path, {"5 vertices a frame", "neutral.obj has 4"});
    write_npy(path / "vertices.npy", {3, 4, 2}, std::vector<float>(24, 1));
    expect_message(path, {"shape [3, 4, 2]"});
    write_clip(path, clip, {.overwrite = true}).ok();
    fs::remove(path / "texture" / "000001.png");
    expect_message(path, {"number 1 is missing"});
    fs::remove(path / "texture" / "000002.png");
    EXPECT_TRUE(load_clip(path));  // one picture is a static texture
    write_image(path / "texture" / "000001.png", Image(4, 3, 3));
    expect_message(path, {"texture has 2 frames", "the motion has 3"});
    write_image(path / "texture" / "000002.png", Image(5, 3, 3));
    const ClipReport report = check_clip(path);
    EXPECT_FALSE(report.good());
    EXPECT_NE(report.text().find("000001.png is 4 x 3"), std::string::npos) << report.text();
}

TEST_F(BadClip, CheckListsEverythingAtOnce) {
    std::vector<float> xyz(3 * 4 * 3, std::numeric_limits<float>::quiet_NaN());
    write_npy(path / "vertices.npy", {3, 4, 3}, xyz);
    fs::remove(path / "sound.wav");
    write_npy(path / "gaze.npy", {2, 4}, std::vector<float>(8));
    const ClipReport report = check_clip(path);
    EXPECT_FALSE(report.good());
    for (const char* word : {"vertices.npy: vertices 0-3 of frames 0-2 are not a number\n", "sound.wav", "gaze.npy has 2 frames"})
        EXPECT_NE(report.text().find(word), std::string::npos) << word << "\n" << report.text();
}

TEST_F(BadClip, CheckNamesEveryPointAndFrameInFewLines) {
    constexpr std::int64_t kFrames = 40;
    const float infinity = std::numeric_limits<float>::infinity();
    Clip long_clip = full_clip();
    long_clip.vertices.reset();
    long_clip.head_pose.clear();
    long_clip.gaze.clear();
    long_clip.texture.reset();
    long_clip.mask.reset();
    long_clip.sound.reset();
    long_clip.rigid.clear();
    long_clip.marker_sites.clear();
    long_clip.markers.emplace(kFrames, 7);
    long_clip.weights.emplace(kFrames, 2);
    long_clip.weights->names = {"JawOpen", "Smile"};
    for (std::int64_t f = 0; f < kFrames; ++f) {
        for (int m = 0; m < 7; ++m) long_clip.markers->frame(f).row(m) = Vec3(10 * float(m), 3 * float(m % 3), 0).transpose();
        // Every second frame is one of more than eight runs.
        if (f % 2 == 0) long_clip.markers->frame(f)(5, 1) = infinity, long_clip.weights->frame(f)[1] = infinity;
        if ((f >= 3 && f <= 17) || f == 20) long_clip.markers->frame(f)(1, 0) = long_clip.markers->frame(f)(2, 2) = -infinity;
    }
    ASSERT_TRUE(write_clip(path, long_clip, {.overwrite = true}));
    const std::string even = "0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 34, 36, 38";
    const ClipReport report = check_clip(path);
    for (const std::string& said : {"markers.npy: marker 5 of frames " + even + " is infinite", std::string("markers.npy: markers 1-2 of frames 3-17, 20 are infinite"),
                                    "weights.npy: weight 1 (Smile) of frames " + even + " is infinite"}) {
        EXPECT_NE(report.text().find(said + "\n"), std::string::npos) << said << "\n" << report.text();
        EXPECT_NE(report.json().find(said + "\""), std::string::npos) << said << "\n" << report.json();
    }
    EXPECT_EQ(report.findings.size(), 3u) << report.text();
    // Who only wants to encode reads the beginning.
    expect_message(path, {"marker 5 of frames 0, 2, 4, 6, 8, 10, 12, 14, ... (20 in all) is infinite"});
}

TEST_F(BadClip, NumbersThatAreNotFiniteInNumberedMeshesAreNamedByFrameAndVertex) {
    const TemporaryFolder meshes;
    const std::string plane = "v 0 0 0\nv 200 0 0\nv 0 250 0\nf 1 2 3\n", bad = "v 0 0 0\nv 200 nan 0\nv inf 250 0\nf 1 2 3\n";
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (int f = 0; f < 4; ++f) write_file(meshes / ("f" + std::to_string(f + 7) + ".obj"), f % 2 == 0 ? bad : plane);
    const std::string text = check_clip(meshes.path()).text();
    for (const char* said : {"f7.obj: line 2: vertices 1-2 are not finite (frame 0)\n", "f9.obj: line 2: vertices 1-2 are not finite (frame 2)\n"})
        EXPECT_NE(text.find(said), std::string::npos) << said << "\n" << text;
    expect_message(meshes.path(), {"f7.obj: line 2: vertices 1-2 are not finite (frame 0)"});
    const TemporaryFolder plies;
    for (int f = 0; f < 3; ++f) write_file(plies / ("f" + std::to_string(f) + ".ply"), ply + "0 0 0\n200 0 0\n0 " + (f == 2 ? "nan" : "250") + " 0\n");
    expect_message(plies.path(), {"f2.ply: vertex 2 is not finite (frame 2)"});
}

TEST_F(BadClip, CheckNamesEveryMeshThatDoesNotFit) {
    const TemporaryFolder meshes;
    write_obj(meshes / "f0.obj", small_head());
    for (int f = 1; f < 13; ++f) write_file(meshes / ("f" + std::to_string(f) + ".obj"), "v 0 0 0\nv 1 1 1\n");
    write_file(meshes / "f5.obj", "v 0 0 zero\n");
    const std::string text = check_clip(meshes.path()).text();
    EXPECT_NE(text.find("f1.obj to f12.obj (frames 1-4, 6-12) have 2 vertices, but f0.obj has 4"), std::string::npos) << text;
    EXPECT_NE(text.find("f5.obj"), std::string::npos) << text;
    for (const int f : {3, 7, 8}) fs::remove(meshes / ("f" + std::to_string(f) + ".obj"));
    EXPECT_NE(check_clip(meshes.path()).text().find("numbers 3, 7-8 are missing"), std::string::npos) << check_clip(meshes.path()).text();
}

TEST_F(BadClip, WhatDependsOnAPartThatCannotBeReadIsNotComplainedAbout) {
    const auto only = [&](const std::string& cause) {
        const ClipReport report = check_clip(path);
        EXPECT_EQ(std::ranges::count_if(report.findings, [](const Finding& f) { return f.severity != Severity::note; }), 1) << cause << "\n" << report.text();
        EXPECT_FALSE(report.good());
        EXPECT_NE(report.text().find(cause), std::string::npos) << report.text();
    };
    // Each part in turn is missing, and each entry in turn is none.
    for (const char* file : {"vertices.npy", "markers.npy", "weights.npy", "neutral.obj", "marker_sites.npy", "rigid.npy", "blendshapes.npy", "head_pose.npy",
                             "gaze.npy", "mask.png", "sound.wav", "texture"}) {
        fs::rename(path / file, path / "aside");
        only(file);
        fs::rename(path / "aside", path / file);
    }
    const std::string json = read_text(path / "clip.json").value();
    const auto with = [&](const std::string& key, const std::string& value) {
        const std::size_t at = json.find("\"" + key + "\": ") + key.size() + 4, end = json.find_first_of(",\n", at);
        ASSERT_NE(json.find("\"" + key + "\": "), std::string::npos) << key;
        describe(json.substr(0, at) + value + json.substr(end));
        only("\"" + key + "\"");
    };
    for (const char* key : {"fps", "unit", "vertices", "markers", "weights", "neutral", "marker_sites", "rigid", "head_pose", "gaze", "masks", "sound", "texture"})
        with(key, "true");
    // Without what only the broken part would have told.
    const auto described = [&](const std::string& text, const std::string& cause) {
        describe(text);
        only(cause);
    };
    described(R"({"markers": "m.trc", "sound": "sound.wav", "rigid": [0, 3], "weights": "weights.npy"})", "m.trc");
    described(R"({"fps": 30, "unit": "cm", "vertices": "v/%04d.obj", "weights": "weights.npy", "blendshapes": "blendshapes.npy", "marker_sites": [0], "markers": "markers.npy", "rigid": [3]})",
              "v/%04d.obj");
    described(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "markers": "markers.npy", "marker_sites": [2, 7]})", "entry 1 names vertex 7 of 4");
    described(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "weights": "weights.npy", "blendshapes": ["neutral.obj", "none.obj"]})", "none.obj");
    described(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "weights": "weights.npy", "weight_names": ["a", "b"], "blendshapes": "targets"})", "targets");
    described(R"({"fps": 30, "unit": "cm", "weights": "weights.npy", "positions_medium": 7, "positions_fine": "fine", "albedo": "albedo"})", "positions_medium");
    described("{\"fps\": 30,", "clip.json is not JSON");
    // Those of a folder of targets are told by their names.
    fs::create_directory(path / "targets");
    write_obj(path / "targets" / "a.obj", small_head());
    write_file(path / "targets" / "b.obj", "v 1 2\n");
    described(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "weights": "weights.npy", "weight_names": ["a", "b"], "blendshapes": "targets"})", "b.obj");
    // What is wrong by itself is still told.
    describe(R"({"fps": true, "unit": "cm", "neutral": "neutral.obj"})");
    EXPECT_NE(check_clip(path).text().find("no motion"), std::string::npos) << check_clip(path).text();
}

TEST(PlainFolder, AMissingNumberIsAllThatIsWrong) {
    const TemporaryFolder folder;
    for (const int f : {0, 1, 3}) write_obj(folder / ("f" + std::to_string(f) + ".obj"), small_head());
    write_npy(folder / "weights.npy", {4, 1}, std::vector<float>(4));
    std::vector<std::string> problems;
    for (const Finding& finding : check_clip(folder.path()).findings)
        if (finding.severity == Severity::problem) problems.push_back(finding.text);
    ASSERT_EQ(problems.size(), 1u) << problems.back();
    EXPECT_NE(problems[0].find("number 2 is missing"), std::string::npos) << problems[0];
}

TEST_F(BadClip, UnitMistakesAreNamedWithTheUnitThatWasMeant) {
    // A head of 0.2 mm, and one of 200 m.
    for (const auto& [scale, unit, meant, size] : std::initializer_list<std::tuple<double, const char*, const char*, const char*>>{
             {1000, "mm", "\"m\"", "0.25 mm"}, {1, "m", "\"mm\"", "250 m"}, {10, "mm", "\"cm\"", "25 mm"}}) {
        write_obj(path / "neutral.obj", small_head(), scale);
        describe(std::string(R"({"fps": 30, "unit": ")") + unit + R"(", "neutral": "neutral.obj", "weights": "weights.npy"})");
        const auto loaded = load_clip(path);
        ASSERT_TRUE(loaded) << loaded.error().message;
        EXPECT_TRUE(warns(*loaded, size) && warns(*loaded, meant)) << loaded->warnings.at(0);
        EXPECT_FALSE(check_clip(path).good());
    }
}

TEST_F(BadClip, MotionOfAnotherSizeThanItsNeutralMeshIsAProblem) {
    const auto of_vertices = [&](auto change) {
        Clip other = clip;
        change(*other.vertices);
        EXPECT_TRUE(write_clip(path, other, {.overwrite = true}));
    };
    of_vertices([](PointSequence& points) { for (float& v : points.xyz) v *= 10; });
    expect_message(path, {"vertices.npy is 2.5 m large", "neutral.obj is 250 mm", "one unit"});
    of_vertices([](PointSequence& points) { for (float& v : points.xyz) v /= 1000; });
    expect_message(path, {"vertices.npy is 0.25 mm large"});
    of_vertices([](PointSequence& points) { for (float& v : points.xyz) v = 0; });
    expect_message(path, {"vertices.npy is 0 mm large"});
    of_vertices([](PointSequence& points) { points.frame(1)(2, 0) = 1e30f; });
    expect_message(path, {"vertices.npy", "vertex 2 of frame 1", "more than a kilometre away"});
    Clip other = clip;
    other.markers.emplace(3, 4);
    for (int f = 0; f < 3; ++f) other.markers->frame(f) = clip.neutral->positions * 1000;
    other.marker_sites.clear();
    ASSERT_TRUE(write_clip(path, other, {.overwrite = true}));
    expect_message(path, {"markers.npy is 250 m large", "neutral.obj is 250 mm"});
    EXPECT_FALSE(check_clip(path).good());
}

TEST_F(BadClip, WhatIsAskedForAgainstTheDescriptionIsWarnedAbout) {
    const auto asked = load_clip(path, {.frame_rate = Rational{25, 1}, .unit = Unit::m});
    ASSERT_TRUE(asked) << asked.error().message;
    EXPECT_TRUE(warns(*asked, "says 30000/1001 frames a second"));
    EXPECT_TRUE(warns(*asked, "says its unit is cm"));
    EXPECT_TRUE(warns(*asked, "ask for cm, or for none")) << "it stands in clip.json already";
    const auto same = load_clip(path, {.frame_rate = Rational{30000, 1001}, .unit = Unit::cm});
    ASSERT_TRUE(same);
    EXPECT_TRUE(same->warnings.empty());
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

TEST_F(BadClip, TheDescriptionIsCheckedKeyByKey) {
    describe("{\"fps\": 30,");
    expect_message(path, {"clip.json is not JSON: parse error at line 1"});
    describe("[]");
    expect_message(path, {"not a JSON object"});
    describe(std::string(100000, '['));
    expect_message(path, {"not a JSON object"});
    describe(R"({"fps": 30, "unit": "mm"})");
    expect_message(path, {"no motion"});
    describe(R"({"fps": -1, "weights": "weights.npy"})");
    expect_message(path, {"\"fps\""});
    describe(R"({"fps": 30, "unit": "inch", "weights": "weights.npy"})");
    expect_message(path, {"\"unit\""});
    describe(R"({"fps": 30, "weights": "other.npy"})");
    expect_message(path, {"there is no file", "other.npy"});
    for (const char* bad : {"/etc/passwd", "../take/weights.npy", "a/../../weights.npy", ""}) {
        describe(std::string(R"({"fps": 30, "weights": ")") + bad + "\"}");
        expect_message(path, {"\"weights\""});
    }
    describe(R"({"fps": 29.97, "unit": "mm", "weights": "weights.npy", "wieghts": 3})");
    const auto loaded = load_clip(path);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->clip.frame_rate, (Rational{2997, 100}));
    EXPECT_TRUE(warns(*loaded, "wieghts"));
    describe(R"({"fps": 30, "unit": "mm", "neutral": "neutral.obj", "vertices": "vertices.npy", "rigid": [0, 9]})");
    expect_message(path, {"rigid names vertex 9"});
    describe(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "markers": "markers.npy", "marker_sites": [7, [1, 0.5, 0.5, 0.5]]})");
    expect_message(path, {"entry 0 names vertex 7 of 4"});
}

TEST_F(BadClip, SoundOfAnotherLengthIsAWarning) {
    for (const auto& [samples, word] : {std::pair(100000, "longer"), std::pair(10, "shorter")}) {
        write_wav(path / "sound.wav", {48000, 1, std::vector<float>(std::size_t(samples))});
        if (samples == 10) {
            clip.vertices.reset();
            describe(R"({"fps": 5, "unit": "cm", "weights": "weights.npy", "sound": "sound.wav"})");
        }
        const auto loaded = load_clip(path);
        ASSERT_TRUE(loaded) << loaded.error().message;
        EXPECT_TRUE(warns(*loaded, word));
    }
    write_file(path / "sound.wav", "RIFF");
    expect_message(path, {"sound.wav"});
}

TEST_F(BadClip, AnEmptyClipIsRefused) {
    write_npy(path / "weights.npy", {0, 2}, {});
    describe(R"({"fps": 30, "unit": "mm", "weights": "weights.npy"})");
    expect_message(path, {"no frames"});
    fs::create_directory(folder / "empty");
    expect_message(folder / "empty", {"no motion"});
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
