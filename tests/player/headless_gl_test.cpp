#include "player/headless.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/environment_error.hpp"
#include "driven_stream.hpp"
#include "io/image_file.hpp"
#include "player/contact_sheet.hpp"
#include "render/context.hpp"
#include "small_stream.hpp"

namespace mien::player {
namespace {

class HeadlessGLTest : public testing::Test {
protected:
    void SetUp() override {
        try {
            const render::OffscreenContext context;
        } catch (const EnvironmentError& error) {
            GTEST_SKIP() << "skipped: " << error.what();
        }
        options_.input = store(small_stream(), folder_);
        options_.headless = true;
        options_.width = 96;
        options_.height = 108;
        options_.stats = folder_.path() / "stats.json";
    }
    Image read(const std::filesystem::path& path) {
        auto image = io::read_image(path);
        EXPECT_TRUE(image.ok());
        return image.ok() ? *image : Image(1, 1, 3);
    }

    TemporaryFolder folder_;
    Options options_;
};

TEST_F(HeadlessGLTest, APictureShowsTheAskedMoment) {
    const auto picture = [&](double time) {
        options_.time = time;
        options_.output = folder_.path() / "x.png";
        EXPECT_EQ(run_headless(options_, steady_seconds()), 0);
        return read(options_.output);
    };
    const Image early = picture(0), late = picture(1.9);
    ASSERT_EQ(early.width, 96);
    EXPECT_GT(late.at(48, 54)[1], early.at(48, 54)[1] + 40) << "the numbered texture brightens with time";
}

TEST_F(HeadlessGLTest, AMovieASheetAndFiguresComeInOnePass) {
    options_.output = folder_.path() / "x.mp4";
    options_.sheet = folder_.path() / "sheet.png";
    ASSERT_EQ(run_headless(options_, steady_seconds()), 0);
    EXPECT_GT(std::filesystem::file_size(options_.output), 1000u);
    const Image sheet = read(options_.sheet);
    EXPECT_EQ(sheet.width % ContactSheet::kMoments, 0);
    // The ball brightens from the first column to the last.
    const int tile = sheet.width / ContactSheet::kMoments;
    EXPECT_GT(sheet.at(sheet.width - tile / 2, sheet.height / 2)[1], sheet.at(tile / 2, sheet.height / 2)[1] + 40);

    std::ifstream file(options_.stats);
    const auto json = nlohmann::json::parse(file);
    EXPECT_GE(json["frames"], kFrames);
    EXPECT_GT(json["startup_s"], 0);
    EXPECT_GT(json["frames_per_second"], 0);
    for (const char* track : {"motion", "texture", "sound"}) EXPECT_GT(json["bytes"][track], 0) << track;
}

TEST_F(HeadlessGLTest, ABenchmarkDrawsEveryFrameAndSaysWhatEachCosts) {
    options_.benchmark = true;
    ASSERT_EQ(run_headless(options_, steady_seconds()), 0);
    std::ifstream file(options_.stats);
    const auto json = nlohmann::json::parse(file);
    EXPECT_EQ(json["frames"], kFrames);
    EXPECT_GT(json["frames_per_second"], 0);
    const auto& cost = json["milliseconds_per_frame"];
    for (const char* part : {"upload", "draw", "processor"}) EXPECT_GT(cost[part], 0) << part;
    const double sum = cost["wait"].get<double>() + cost["upload"].get<double>() + cost["draw"].get<double>();
    EXPECT_NEAR(sum, 1000 / json["frames_per_second"].get<double>(), 1e-6 * sum) << "nothing between the parts is left out";
}

TEST_F(HeadlessGLTest, APartOfTheModelDrawsItsPictureAndTheWholeOneDrawsAsAFileDoes) {
    const net::harness::Served served(driven_stream());
    struct Run {
        Image picture{1, 1, 3};
        nlohmann::json figures;
    };
    const auto run = [&](std::string input, std::optional<double> model_kb) {
        options_.input = std::move(input);
        options_.model_kb = model_kb;
        options_.output = folder_.path() / "x.png";
        EXPECT_EQ(run_headless(options_, steady_seconds()), 0);
        std::ifstream file(options_.stats);
        return Run{read(options_.output), nlohmann::json::parse(file)};
    };
    const std::string url = to_string(served.url());
    const Run file = run((served.folder.path() / "take.mien").string(), {}), whole = run(url, {}), part = run(url, 0), most = run(url, 1e6);
    EXPECT_EQ(whole.picture.pixels, file.picture.pixels);
    EXPECT_EQ(most.picture.pixels, file.picture.pixels);
    EXPECT_NE(part.picture.pixels, file.picture.pixels);
    EXPECT_EQ(whole.figures["model"]["bytes"], whole.figures["model"]["of"]);
    EXPECT_EQ(part.figures["model"]["bytes"], needed_bytes(served.stream)) << "and no more came while it was drawn";
    EXPECT_LT(part.figures["startup_bytes"], whole.figures["startup_bytes"]);
    EXPECT_GT(part.figures["startup_bytes"], part.figures["bytes"]["model"]);
}

TEST_F(HeadlessGLTest, WhatIsWrongIsAnExitCode) {
    options_.output = folder_.path() / "x.png";
    options_.time = 100;
    EXPECT_EQ(run_headless(options_, steady_seconds()), 1) << "after the end";
    options_.time = 0;
    options_.input = (folder_.path() / "nothing.mien").string();
    EXPECT_EQ(run_headless(options_, steady_seconds()), 1);
    EXPECT_FALSE(std::filesystem::exists(options_.output));
}

}  // namespace
}  // namespace mien::player
