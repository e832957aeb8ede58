#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "io/clip_check.hpp"
#include "io/file.hpp"
#include "io/image_file.hpp"
#include "io/npy.hpp"
#include "io/obj.hpp"
#include "io/sound_file.hpp"
#include "small_clip.hpp"
#include "tests/temporary_folder.hpp"

/// What is wrong with a clip, and how it is said.
namespace mien::io {
namespace {

using namespace test;
using tests::TemporaryFolder;

namespace fs = std::filesystem;

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
    expect_message(path, {"marker_sites.npy has 2 entries", "5 markers"});
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

TEST_F(BadClip, AMissingNumberHidesNothingElse) {
    const auto problems_of = [](const fs::path& clip_path) {
        std::string text;
        for (const Finding& finding : check_clip(clip_path).findings)
            if (finding.severity != Severity::note) text += finding.text + "\n";
        return text;
    };
    // Of the texture: the mask is another's, and a later picture too small; nothing is wrong with its length.
    write_image(path / "mask.png", Image(7, 3, 1));
    fs::remove(path / "texture" / "000001.png");
    write_image(path / "texture" / "000002.png", Image(4, 3, 3));
    const std::string of_texture = problems_of(path);
    EXPECT_EQ(std::ranges::count(of_texture, '\n'), 3) << of_texture;
    for (const char* said : {"number 1 is missing between", "the mask is 7 x 3", "texture frame 2: "}) EXPECT_NE(of_texture.find(said), std::string::npos) << said << "\n" << of_texture;
    expect_message(path, {"number 1 is missing", "(and 1 more problem: 'mien check "});
    // Of vertices: frames keep their numbers, of two files of one number the first counts, and markers of as many frames fit.
    const TemporaryFolder meshes;
    for (const char* name : {"f3.obj", "f5.obj", "f05.obj", "f7.obj"}) write_obj(meshes / name, small_head());
    write_file(meshes / "f8.obj", "v 0 0 zero\nv 1 2\n");
    write_npy(meshes / "markers.npy", {6, 2, 3}, std::vector<float>(36, 1));
    write_file(meshes / "clip.json", R"({"fps": 30, "unit": "mm", "vertices": "f%d.obj", "markers": "markers.npy"})");
    const std::string of_meshes = problems_of(meshes.path());
    EXPECT_EQ(std::ranges::count(of_meshes, '\n'), 2) << of_meshes;
    EXPECT_NE(of_meshes.find("numbers 4, 6 are missing between"), std::string::npos) << of_meshes;
    EXPECT_NE(of_meshes.find("f05.obj and f5.obj have the same number"), std::string::npos) << of_meshes;
    EXPECT_NE(of_meshes.find("f8.obj: line 1: vertex 0 has no three numbers; line 2: vertex 1 has no three numbers (frame 5)"), std::string::npos) << of_meshes;
    EXPECT_FALSE(load_clip(meshes.path()));
    // A few files far apart are no sequence.
    for (const char* name : {"f3.obj", "f7.obj", "f8.obj"}) fs::remove(meshes / name);
    write_obj(meshes / "f900000000.obj", small_head());
    const std::string sparse = problems_of(meshes.path());
    EXPECT_NE(sparse.find("numbers 6-899999999 are missing"), std::string::npos) << sparse;
    EXPECT_EQ(std::ranges::count(sparse, '\n'), 1) << sparse;
}

TEST_F(BadClip, EveryBadEntryOfTheDescriptionIsNamed) {
    describe(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "weights": "weights.npy", "rigid": [0, "a", 1, [2, "b"], null], "marker_sites": [true, 1],
                 "takes": [{"first": 1}, {"name": "x"}, {"first": 1}, 7, {"first": 2}]})");
    const std::string text = check_clip(path).text();
    for (const char* said : {"\"rigid\" entries 1, 3-4 are not a number or a row of numbers\n", "\"marker_sites\" entry 0 is not a number or a row of numbers\n",
                             "\"takes\" must begin with frame 0; entry 1 lacks \"first\", the take's first frame; must ascend, but frame 1 follows 1; entry 3 lacks \"first\", the take's first frame\n"})
        EXPECT_NE(text.find(said), std::string::npos) << said << "\n" << text;
}

TEST_F(BadClip, RigidPointsAreNamedByFileAndEntry) {
    write_file(path / "skull.txt", "0\n-1\n2.5\n9\n");
    describe(R"({"fps": 30, "unit": "cm", "neutral": "neutral.obj", "weights": "weights.npy", "rigid": "skull.txt"})");
    const std::string text = check_clip(path).text();
    for (const char* said : {"skull.txt: entry 1 is no index but -1; entry 2 is no index but 2.5\n", "skull.txt names vertex 9 (entry 3), but there are 4\n"})
        EXPECT_NE(text.find(said), std::string::npos) << said << "\n" << text;
}

TEST_F(BadClip, APoseThatIsNoNumberIsToldOnce) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::vector<float> poses(21);
    poses[0] = poses[7] = poses[14] = 1;
    poses[8] = nan, poses[18] = nan;
    write_npy(path / "head_pose.npy", {3, 7}, poses);
    const ClipReport report = check_clip(path);
    EXPECT_NE(report.text().find("head_pose.npy: frames 1-2 are not finite\n"), std::string::npos) << report.text();
    EXPECT_EQ(std::ranges::count_if(report.findings, [](const Finding& f) { return f.severity != Severity::note; }), 1) << report.text();
    poses[8] = 0, poses[18] = 0;
    poses[14] = 0;
    write_npy(path / "head_pose.npy", {3, 7}, poses);
    EXPECT_NE(check_clip(path).text().find("head_pose.npy: frame 2 is no rotation and translation\n"), std::string::npos) << check_clip(path).text();
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
    for (const char* rate : {"1e9", "1000000000", "0.001"}) {
        describe(std::string(R"({"fps": )") + rate + R"(, "weights": "weights.npy"})");
        expect_message(path, {"\"fps\" must be frames per second, from 0.01 to 1000"});
    }
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

}  // namespace
}  // namespace mien::io
