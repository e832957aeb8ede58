#include "player/headless.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/environment_error.hpp"
#include "driven_stream.hpp"
#include "io/image_file.hpp"
#include "media/video_reader.hpp"
#include "net/stored_stream.hpp"
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

TEST_F(HeadlessGLTest, WhatIsDamagedIsNamedAndTheRestIsWritten) {
    std::string bytes;
    {
        std::ifstream file(options_.input, std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(file), {});
    }
    const auto reader = net::open_stored_stream(options_.input);
    ASSERT_TRUE(reader.ok());
    const auto slot = [&](protocol::TrackKind kind) { return std::ranges::find(reader->header().tracks, kind, &protocol::Track::kind)->rungs.front().slot; };
    const auto spoil = [&](protocol::TrackKind kind, std::uint32_t group) {
        const protocol::IndexEntry* entry = reader->find(slot(kind), group);
        bytes[entry->offset + entry->size / 2] ^= 1;
    };
    spoil(protocol::TrackKind::texture, 1);
    spoil(protocol::TrackKind::motion, 2);
    spoil(protocol::TrackKind::sound, 3);
    std::ofstream(options_.input, std::ios::binary) << bytes;

    options_.output = folder_.path() / "x.mp4";
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_headless(options_, steady_seconds()), 1);
    const std::string said = testing::internal::GetCapturedStderr();
    for (const char* stretch : {"texture damaged or missing from 0:00.50 to 0:01.00", "motion damaged or missing from 0:01.00 to 0:01.50", "sound damaged or missing from 0:01.5"})
        EXPECT_NE(said.find(stretch), std::string::npos) << stretch << " is not in:\n" << said;
    auto movie = media::VideoReader::open(options_.output);
    ASSERT_TRUE(movie.ok()) << movie.error().message;
    EXPECT_EQ((*movie)->frames(), kFrames) << "lost frames repeat the one before";
    std::ifstream figures(options_.stats);
    EXPECT_EQ(nlohmann::json::parse(figures)["damage"].size(), 3u);

    // A moment that is sound is shown without a word.
    options_.output = folder_.path() / "x.png";
    options_.time = 0.2;
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_headless(options_, steady_seconds()), 0);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(HeadlessGLTest, ACutFileIsShownAsFarAsItGoes) {
    const auto reader = net::open_stored_stream(options_.input);
    ASSERT_TRUE(reader.ok());
    std::filesystem::resize_file(options_.input, reader->find(reader->header().tracks.front().rungs.front().slot, 2)->offset);
    options_.output = folder_.path() / "x.mp4";
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_headless(options_, steady_seconds()), 1);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("it is cut"), std::string::npos) << said;
    EXPECT_NE(said.find("motion damaged or missing from 0:01.00 to 0:02.00"), std::string::npos) << said;
    auto movie = media::VideoReader::open(options_.output);
    ASSERT_TRUE(movie.ok()) << movie.error().message;
    EXPECT_EQ((*movie)->frames(), kFrames / 2);
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
