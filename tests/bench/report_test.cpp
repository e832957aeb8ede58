#include "bench/report.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "bench/picture_score.hpp"
#include "bench/report_plots.hpp"
#include "bench/report_tables.hpp"
#include "bench/short_clip.hpp"
#include "bench/suite.hpp"
#include "bench/timing.hpp"

namespace mien::bench {
namespace {

std::filesystem::path temporary(const std::string& name) {
    return std::filesystem::temp_directory_path() / ("mien-bench-" + std::to_string(getpid()) + name);
}

Report small_report() {
    Report report;
    report.version = own_library();
    report.commands = {"mien-bench 'a & b' <c>"};
    report.codecs = {{"mien-live", "ours"}, {"zstd-delta", "theirs"}};
    report.absent = {{"draco-mesh-best", "not, \"there\""}};
    ClipFacts clip;
    clip.name = "one <two>";
    clip.key = "one#1";
    clip.kind = "vertices";
    clip.frames = clip.points = 10;
    report.clips = {clip};
    for (const double rms : {0.2, 0.1}) {
        GeometryRow row;
        row.clip = "one#1";
        row.codec = "mien-live";
        row.library = own_library();
        row.mode = "live";
        row.asked_rms = row.rms = rms;
        row.bytes = 100;
        row.kbps = 1 / rms;
        row.parts = {{"basis", 60}, {"coefficients", 40}};
        report.geometry.push_back(row);
        row.codec = "zstd-delta";
        row.library = "zstd 9";
        row.parts = {{"packets", 100}};
        row.kbps *= 4;
        report.geometry.push_back(row);
    }
    TextureRow texture;
    texture.clip = "one#1";
    texture.codec = "h264";
    texture.library = "FFmpeg 9";
    texture.series = "plain";
    texture.psnr_y = texture.worst_psnr_y = std::numeric_limits<double>::infinity();
    report.texture = {texture};
    return report;
}

TEST(Report, ComesBackFromJson) {
    const Report report = small_report();
    const auto path = temporary(".json");
    write_file(path, to_json(report));
    const auto back = read_json(path);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(to_json(*back), to_json(report));
    EXPECT_TRUE(std::isinf(back->texture[0].psnr_y));
    EXPECT_EQ(back->geometry[0].parts, report.geometry[0].parts);

    std::ofstream(path) << "{\"format\": \"something else\"}";
    EXPECT_EQ(read_json(path).error().code, ErrorCode::damaged);
    std::ofstream(path) << "{\"format\": ";
    EXPECT_EQ(read_json(path).error().code, ErrorCode::damaged);
    std::filesystem::remove(path);
    EXPECT_EQ(read_json(path).error().code, ErrorCode::missing);
}

TEST(Report, PageNeedsNothingElseAndEscapesNames) {
    const std::string page = to_html(small_report());
    for (const char* fetch : {"http:", "https:", "src=", "<script", "@import", "url("})
        EXPECT_EQ(page.find(fetch), std::string::npos) << fetch;
    EXPECT_EQ(page.find("<two>"), std::string::npos);
    EXPECT_NE(page.find("one &lt;two&gt;"), std::string::npos);
    EXPECT_NE(page.find("<svg"), std::string::npos);
    EXPECT_NE(page.find("a &amp; b"), std::string::npos);
    EXPECT_NE(page.find("not, &quot;there&quot;"), std::string::npos);
}

TEST(Report, TablesShowRatesAndTheirBdRate) {
    const Report report = small_report();
    const Table headline = headline_table(report);
    ASSERT_EQ(headline.rows.size(), 1u);
    EXPECT_EQ(headline.rows[0].cells[2], "5.000");
    EXPECT_EQ(headline.rows[0].cells[3], "20.00 zstd-delta");
    const auto tables = geometry_tables(report, report.clips[0]);
    ASSERT_FALSE(tables.empty());
    EXPECT_EQ(tables[0].rows[1].cells.back(), "-75.0 %");  // a quarter of the rate
    EXPECT_NE(to_markdown(report).find("| zstd-delta | live |"), std::string::npos);
    const std::string csv = to_csv(report);
    EXPECT_NE(csv.find("geometry,one#1,mien-live,"), std::string::npos);
    const auto commas = std::count(csv.begin(), csv.begin() + std::ptrdiff_t(csv.find('\n')), ',');
    for (std::size_t at = 0; at < csv.size(); at = csv.find('\n', at) + 1)
        EXPECT_EQ(std::count(csv.begin() + std::ptrdiff_t(at), csv.begin() + std::ptrdiff_t(csv.find('\n', at)), ','), commas);
}

TEST(Figure, HasTheAskedDigits) {
    EXPECT_EQ(figure(1234.5, 3), "1234");
    EXPECT_EQ(figure(12.345, 4), "12.35");
    EXPECT_EQ(figure(0.012345, 3), "0.0123");
    EXPECT_EQ(figure(0, 3), "0");
    EXPECT_EQ(figure(std::numeric_limits<double>::infinity(), 3), "∞");
}

TEST(SvgPlot, LeavesOutWhatCannotBeShown) {
    Plot plot{"t",
              "x",
              "y",
              true,
              false,
              false,
              {{"a", 0, 0, false, {{1, 2, ""}, {0, 3, ""}, {10, std::numeric_limits<double>::infinity(), ""}}}}};
    const std::string svg = svg_plot(plot);
    EXPECT_NE(svg.find("<circle"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    plot.series[0].points = {{0, 3, ""}};
    EXPECT_EQ(svg_plot(plot), "");
}

TEST(Quantile, LiesBetweenSamples) {
    EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
    EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0), 1);
    EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2, 5}, 0.25), 2);
}

TEST(PictureScore, AddsUpErrorsAndKeepsTheWorst) {
    Image black(8, 8, 3), grey = black;
    for (auto& p : grey.pixels) p = 10;
    PictureScore score;
    std::vector<std::uint8_t> counted(64, 1);
    score.add(black, black, counted);
    EXPECT_TRUE(std::isinf(score.psnr_y()));
    score.add(black, grey, counted);
    EXPECT_NEAR(score.psnr_y(), 10 * std::log10(255.0 * 255 / 50), 1e-3);  // half of 100
    EXPECT_NEAR(score.worst_psnr_y(), 10 * std::log10(255.0 * 255 / 100), 1e-3);
    score.add(black, grey, std::vector<std::uint8_t>(64, 0));
    EXPECT_EQ(score.pictures(), 2);
}

TEST(Suite, KeepsFinishedRowsAndRunsStaleOnesAgain) {
    const Clip clip = sheet_clip();
    SuiteOptions options;
    options.rms = {0.2};
    options.codecs = {"mien-live", "zstd"};
    options.timing = options.texture = false;
    Report report;
    int saved = 0;
    const auto save = [&] { ++saved; };
    ASSERT_TRUE(run_clip(clip, options, report, save).ok());
    EXPECT_EQ(saved, 2);
    ASSERT_EQ(report.geometry.size(), 2u);
    ASSERT_TRUE(run_clip(clip, options, report, save).ok());
    EXPECT_EQ(saved, 2);

    report.geometry[0].library = "mien 0.0.0-older";
    report.geometry[1].failed = "interrupted";
    drop_other_builds(report);
    EXPECT_EQ(report.geometry.size(), 1u);
    ASSERT_TRUE(run_clip(clip, options, report, save).ok());
    EXPECT_EQ(saved, 4);
    EXPECT_EQ(report.geometry.size(), 2u);
    for (const GeometryRow& row : report.geometry) EXPECT_EQ(row.failed, "");

    options.force = true;
    ASSERT_TRUE(run_clip(clip, options, report, save).ok());
    EXPECT_EQ(saved, 6);
    EXPECT_EQ(report.geometry.size(), 2u);
    options.motion = "markers";
    EXPECT_EQ(run_clip(clip, options, report, save).error().code, ErrorCode::missing);
}

TEST(FirstFrames, AreTheSameFrames) {
    const Clip clip = sheet_clip();
    const Clip cut = first_frames(clip, 5);
    EXPECT_EQ(cut.frame_count(), 5);
    EXPECT_EQ(cut.texture->frames(), 5);
    EXPECT_EQ(cut.vertices->frame(4), clip.vertices->frame(4));
    EXPECT_NE(clip_key(cut), clip_key(clip));
    EXPECT_EQ(clip_key(first_frames(clip, 100)), clip_key(clip));
}

}  // namespace
}  // namespace mien::bench
