#include "tools/options.hpp"

#include <gtest/gtest.h>

#include "io/file.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::tools {
namespace {

std::string said(const CLI::Validator& validator, std::string text) { return validator(text); }

TEST(Options, NumbersAreRefusedInFewWords) {
    for (const char* good : {"1", "0.5", "1e-9", "1e300"}) EXPECT_EQ(said(above_zero(), good), "") << good;
    for (const char* bad : {"0", "-1", "abc", "inf", "nan", "", "1x", "1e999"}) EXPECT_EQ(said(above_zero(), bad), "must be a number above 0") << bad;
    EXPECT_EQ(said(not_negative(), "0"), "");
    EXPECT_EQ(said(not_negative(), "-0.1"), "must be a number, 0 or above");
    EXPECT_EQ(said(number_from(0, 0.9), "0.9"), "");
    for (const char* bad : {"0.91", "-1", "nan"}) EXPECT_EQ(said(number_from(0, 0.9), bad), "must be a number from 0 to 0.9") << bad;
    EXPECT_EQ(said(motion_error(), "1e-9"), "must be a number from 0.0001 to 1000");
    EXPECT_EQ(said(frame_rate(), "30000/1001"), "");
    for (const char* bad : {"abc", "1000000000", "0.001"}) EXPECT_EQ(said(frame_rate(), bad), "must be frames per second, from 0.01 to 1000, as 30, 29.97 or 30000/1001") << bad;
}

TEST(Options, OnlyStreamsAndModelsAreOverwrittenAndNoInput) {
    const tests::TemporaryFolder folder;
    const auto why = [&](const char* name, bool overwrite) {
        const auto may = may_write(folder / name, overwrite, {folder / "basis.mien"});
        return may ? std::string() : may.error().message;
    };
    io::write_file(folder / "old.mien", std::string_view("\x01\xec\x01mien\x04 and so on"));
    io::write_file(folder / "basis.mien", std::string_view("\x01\xec\x01mien\x04 and so on"));
    io::write_file(folder / "neutral.obj", std::string_view("v 0 0 0\n"));
    io::write_file(folder / "empty", std::string_view());
    std::filesystem::create_symlink("basis.mien", folder / "link.mien");
    EXPECT_EQ(why("new.mien", false), "");
    EXPECT_NE(why("old.mien", false).find("-y overwrites"), std::string::npos);
    EXPECT_EQ(why("old.mien", true), "");
    EXPECT_EQ(why("empty", true), "");
    EXPECT_NE(why("neutral.obj", true).find("no stream or model file"), std::string::npos);
    EXPECT_NE(why("basis.mien", true).find("is read"), std::string::npos);
    EXPECT_NE(why("link.mien", true).find("is read"), std::string::npos);
    EXPECT_NE(why("", true).find("is a folder"), std::string::npos);
    EXPECT_FALSE(may_write("/dev/null", true, {}));
}

}  // namespace
}  // namespace mien::tools
