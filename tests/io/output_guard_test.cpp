#include "io/output_guard.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <optional>

#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

/// A folder with a stream, and a clip folder with its clip.json.
class OutputGuard : public testing::Test {
protected:
    void SetUp() override {
        fs::create_directory(folder_ / "clip");
        write("face.mien", "mien");
        write("clip/clip.json", "{\n  \"startup_s\": 1}");
    }
    void write(const char* name, const char* text) { std::ofstream(folder_ / name) << text; }
    std::optional<ErrorCode> of(const std::vector<PlannedOutput>& outputs, bool overwrite = false) {
        const auto guarded = guard_outputs({folder_ / "face.mien", folder_ / "clip", {}}, outputs, overwrite);
        return guarded.ok() ? std::nullopt : std::optional(guarded.error().code);
    }
    tests::TemporaryFolder folder_;
};

constexpr std::nullopt_t kFine = std::nullopt;

TEST_F(OutputGuard, LetsNewFilesBeWritten) {
    EXPECT_EQ(of({{"-o", folder_ / "new.png", {".png"}}, {"--sheet", {}, {".png"}}}), kFine);
    EXPECT_EQ(of({{"-o", folder_ / "clip" / "new.png", {".png"}}}), kFine) << "what is new in a clip folder is no part of the clip";
}

TEST_F(OutputGuard, NothingIsWrittenOverWhatIsReadWhateverLinksLeadThere) {
    fs::create_symlink(folder_ / "face.mien", folder_ / "soft.json");
    fs::create_hard_link(folder_ / "face.mien", folder_ / "hard.json");
    fs::create_directory_symlink(folder_ / "clip", folder_ / "same");
    for (const char* name : {"face.mien", "clip/../face.mien", "soft.json", "hard.json", "clip", "clip/clip.json", "same/clip.json"})
        EXPECT_EQ(of({{"--json", folder_ / name, {}, "{\"startup_s\":"}}, true), ErrorCode::mismatch) << name;
}

TEST_F(OutputGuard, WhatIsThereIsReplacedWhenThatIsAskedForOrWhenItIsAnOlderReport) {
    write("old.png", "picture");
    write("old.json", "{\n    \"startup_s\" : 0.5,\n}");
    write("else.json", "{\"name\": 1}");
    write("short.json", "{");
    write("empty.json", "");
    EXPECT_EQ(of({{"-o", folder_ / "old.png", {".png"}}}), ErrorCode::unavailable);
    EXPECT_EQ(of({{"-o", folder_ / "old.png", {".png"}}}, true), kFine);
    const auto report = [&](const char* name, bool overwrite = false) { return of({{"--json", folder_ / name, {}, "{\"startup_s\":"}}, overwrite); };
    EXPECT_EQ(report("old.json"), kFine);
    EXPECT_EQ(report("empty.json"), kFine);
    EXPECT_EQ(report("else.json"), ErrorCode::unavailable);
    EXPECT_EQ(report("short.json"), ErrorCode::unavailable);
    EXPECT_EQ(report("else.json", true), kFine);
    EXPECT_EQ(of({{"--json", "/dev/null", {}, "{"}}), kFine);
}

TEST_F(OutputGuard, EndingsAreCheckedAndTwoOutputsAreNotOneFile) {
    EXPECT_EQ(of({{"-o", folder_ / "x.mien", {".png", ".mp4"}}}), ErrorCode::invalid);
    EXPECT_EQ(of({{"-o", folder_ / "x.png", {".png"}}, {"--sheet", folder_ / "clip" / ".." / "x.png", {".png"}}}), ErrorCode::invalid);
    const auto guarded = guard_outputs({}, {{"-o", "x.mien", {".png", ".mp4"}}}, true);
    ASSERT_FALSE(guarded.ok());
    EXPECT_EQ(guarded.error().message, "-o writes .png or .mp4, not 'x.mien'");
}

}  // namespace
}  // namespace mien::io
