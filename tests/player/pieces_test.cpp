#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/environment_error.hpp"
#include "player/contact_sheet.hpp"
#include "player/help_layout.hpp"
#include "player/label.hpp"
#include "player/options.hpp"
#include "player/screenshot.hpp"
#include "player/sound_track.hpp"
#include "player/statistics.hpp"
#include "player/view_controls.hpp"
#include "small_stream.hpp"

namespace mien::player {
namespace {

TEST(ParseTime, ReadsWhatPeopleWrite) {
    const std::pair<const char*, double> good[] = {{"90", 90}, {"1.5", 1.5}, {"1:30", 90}, {"0:01:30.5", 90.5}, {"2:00:00", 7200}, {"90:00", 5400}, {"0", 0}};
    for (const auto& [text, seconds] : good) {
        const auto time = parse_time(text);
        ASSERT_TRUE(time.ok()) << text;
        EXPECT_DOUBLE_EQ(*time, seconds) << text;
    }
    for (const char* text : {"", "-1", "1:60", "1:2:3:4", "a", "1.5:00", "1:", ":1", "inf", "nan", "1e3", " 1", "99999999"})
        EXPECT_FALSE(parse_time(text).ok()) << text;
}

TEST(Screenshot, NeverTakesANameThatExists) {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "mien-0001.png") << "mine";
    const auto first = claim_screenshot(folder.path()), second = claim_screenshot(folder.path());
    EXPECT_EQ(first.filename(), "mien-0002.png");
    EXPECT_EQ(second.filename(), "mien-0003.png");
    std::string kept;
    std::ifstream(folder.path() / "mien-0001.png") >> kept;
    EXPECT_EQ(kept, "mine");
}

TEST(Screenshot, SaysWhyAFolderCannotBeWritten) {
    EXPECT_THROW(claim_screenshot("/no/such/folder"), EnvironmentError);
}

TEST(ContactSheet, ShowsTheMiddlesOfEightEqualParts) {
    const ContactSheet sheet(0, 80, 10, 10);
    EXPECT_EQ(sheet.moments(), (std::vector<std::int64_t>{5, 15, 25, 35, 45, 55, 65, 75}));
    const ContactSheet tiny(4, 5, 10, 10);
    for (const std::int64_t moment : tiny.moments()) EXPECT_EQ(moment, 4) << "one frame only";
}

TEST(ContactSheet, PutsATileInItsPlace) {
    ContactSheet sheet(0, 8, 10, 12);
    Image tile(10, 12, 3);
    std::fill(tile.pixels.begin(), tile.pixels.end(), std::uint8_t(77));
    sheet.place(2, 1, tile);
    const Image done = sheet.finish({30, 1});
    EXPECT_EQ(done.width, 80);
    const int head = done.height - 3 * 12;
    EXPECT_EQ(done.at(20, head + 12)[0], 77);
    EXPECT_EQ(done.at(29, head + 23)[0], 77);
    EXPECT_NE(done.at(19, head + 12)[0], 77);
    EXPECT_NE(done.at(30, head + 12)[0], 77);
    EXPECT_NE(done.at(20, head + 24)[0], 77);
}

TEST(Label, WritesInsideThePictureOnly) {
    Image image(40, 12, 3);
    draw_label(image, 2, 2, 1, "a word that is much longer than the picture is wide");
    EXPECT_GT(std::count(image.pixels.begin(), image.pixels.end(), 225), 30);
}

decoder::SoundDecoder::Block block(std::int64_t first, std::vector<float> samples) {
    return {first, Sound{10, 1, std::move(samples)}};
}

TEST(SoundTrack, LaysBlocksInTheirPlaceWhateverTheOrder) {
    SoundTrack track;
    track.add(block(4, {5, 6}));
    track.add(block(0, {1, 2}));
    EXPECT_DOUBLE_EQ(track.end(), 0.6);
    EXPECT_EQ(track.between(0, 0.8).samples, (std::vector<float>{1, 2, 0, 0, 5, 6, 0, 0}));
    EXPECT_EQ(track.between(0.1, 0.5).samples, (std::vector<float>{2, 0, 0, 5}));
}

TEST(SoundTrack, IsEmptyWithoutBlocks) { EXPECT_TRUE(SoundTrack().between(0, 1).samples.empty()); }

TEST(ViewControls, WhatIsUnderTheMouseStaysUnderItWhenPanning) {
    ViewControls controls;
    render::OrbitCamera home;
    home.distance = 500;
    controls.reset(home);
    const auto at = [&](const Vec3& point) -> Vec2 {
        const render::Camera camera = controls.camera().camera();
        const Eigen::Vector4f clip = camera.projection(1) * camera.view() * point.homogeneous();
        return clip.head<2>() / clip.w() * 360;   // pixels from the middle of 720
    };
    const Vec2 before = at(Vec3::Zero());
    controls.drag(true, 36, -18, 720);
    EXPECT_NEAR(at(Vec3::Zero()).x() - before.x(), 36, 0.5);
    EXPECT_NEAR(at(Vec3::Zero()).y() - before.y(), 18, 0.5) << "up in the window is up in the picture";
}

TEST(ViewControls, DraggingTurnsTheFaceWithTheMouse) {
    ViewControls controls;
    controls.drag(false, 50, 0, 720);
    EXPECT_LT(controls.camera().yaw, 0) << "to the right: the actor's right side comes into view";
    const float far = controls.camera().distance;
    controls.wheel(1);
    EXPECT_LT(controls.camera().distance, far);
}

TEST(ViewControls, ANarrowerWindowStepsBackAndAWiderOneReturnsToWhatWasChosen) {
    ViewControls controls;
    render::OrbitCamera wide, narrow;
    wide.distance = 600;
    narrow.distance = 900;
    controls.reset(wide);
    controls.drag(false, 50, 20, 720);
    controls.wheel(2);
    const render::OrbitCamera chosen = controls.camera();
    controls.reshape(narrow);
    EXPECT_FLOAT_EQ(controls.camera().distance, chosen.distance * 1.5f);
    EXPECT_EQ(controls.camera().yaw, chosen.yaw);
    controls.reshape(wide);
    EXPECT_NEAR(controls.camera().distance, chosen.distance, 1e-3f);
}

TEST(Layers, EverySwitchSwitchesOneThingAndBack) {
    for (int layer = 1; layer <= 5; ++layer) {
        render::Look look;
        EXPECT_FALSE(toggle_layer(look, layer).empty());
        for (int other = 1; other <= 5; ++other) EXPECT_EQ(layer_on(look, other), other != layer);
        toggle_layer(look, layer);
        EXPECT_TRUE(layer_on(look, layer));
    }
}

TEST(Help, FitsIntoTheWindowWithItsLettersAsLargeAsCanBe) {
    // 32 entries, as large as they are drawn at 1 and 2 pixels a point.
    for (const float pixels : {1.0f, 2.0f})
        for (const auto& [width, height] : {std::pair(1280.f, 720.f), std::pair(640.f, 480.f), std::pair(480.f, 480.f), std::pair(320.f, 900.f), std::pair(900.f, 200.f), std::pair(240.f, 240.f)}) {
            const float column = 231 * pixels, row = 17 * pixels;
            const HelpLayout layout = fit_help(width, height, 32, column, row);
            EXPECT_GE(layout.columns * layout.rows, 32);
            EXPECT_LE(float(layout.columns) * column * layout.scale, width * 1.0001f) << width << " x " << height;
            EXPECT_LE(float(layout.rows) * row * layout.scale, height * 1.0001f) << width << " x " << height;
            EXPECT_GT(layout.scale, 0.25f);
        }
    EXPECT_EQ(fit_help(640, 480, 32, 231, 17).columns, 2);
    EXPECT_EQ(fit_help(640, 480, 32, 231, 17).scale, 1);
    EXPECT_EQ(fit_help(300, 600, 32, 231, 17).columns, 1) << "a high window";
    EXPECT_EQ(fit_help(300, 600, 32, 231, 17).scale, 1);
    EXPECT_EQ(fit_help(930, 140, 32, 231, 17).columns, 4) << "a low one";
    EXPECT_EQ(fit_help(930, 140, 32, 231, 17).scale, 1);
    EXPECT_GT(fit_help(0, 0, 32, 231, 17).rows, 0);
}

TEST(Statistics, AreJsonWithTheNamesThatScriptsRead) {
    Statistics statistics;
    statistics.startup = 0.25;
    statistics.motion_bytes = 1234;
    statistics.source.bytes = 9999;
    const auto json = nlohmann::json::parse(to_json(statistics));
    EXPECT_EQ(json["startup_s"], 0.25);
    EXPECT_EQ(json["bytes"]["motion"], 1234);
    EXPECT_EQ(json["bytes"]["received"], 9999);
    EXPECT_FALSE(json.contains("rendered_psnr_y_db")) << "nothing was compared";
    EXPECT_THROW(write_json("/no/such/folder/x.json", statistics), EnvironmentError);
}

}  // namespace
}  // namespace mien::player
