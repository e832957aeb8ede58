#include "io/npy.hpp"

#include <gtest/gtest.h>

#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

using tests::TemporaryFolder;

/// A version 1 file around a header dictionary and the array's bytes.
Bytes npy(std::string_view dictionary, std::string_view array) {
    std::string text = "\x93NUMPY";
    text += {'\1', '\0', static_cast<char>(dictionary.size()), '\0'};
    text += dictionary;
    text += array;
    const auto view = std::as_bytes(std::span(text));
    return {view.begin(), view.end()};
}

using namespace std::string_view_literals;
constexpr auto kTwoFloats = "\x00\x00\x80\x3f\x00\x00\x00\xc0"sv;  // 1, -2

TEST(Npy, ReadsEveryNumberType) {
    const auto values = [](std::string_view type, std::string_view array) {
        const auto parsed = parse_npy(npy("{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': (2,), }", array));
        return parsed ? parsed->values : std::vector<float>{};
    };
    const std::vector<float> expected{1, -2};
    EXPECT_EQ(values("<f4", kTwoFloats), expected);
    EXPECT_EQ(values("<f2", "\x00\x3c\x00\xc0"sv), expected);
    EXPECT_EQ(values("<f8", "\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\x00\xc0"sv), expected);
    EXPECT_EQ(values("|i1", "\x01\xfe"sv), expected);
    EXPECT_EQ(values("<i2", "\x01\0\xfe\xff"sv), expected);
    EXPECT_EQ(values("<i4", "\x01\0\0\0\xfe\xff\xff\xff"sv), expected);
    EXPECT_EQ(values("<i8", "\x01\0\0\0\0\0\0\0\xfe\xff\xff\xff\xff\xff\xff\xff"sv), expected);
    EXPECT_EQ(values("|u1", "\x01\xfe"sv), (std::vector<float>{1, 254}));
    EXPECT_EQ(values("<u2", "\x01\0\xfe\xff"sv), (std::vector<float>{1, 65534}));
}

TEST(Npy, ReadsVersionTwoAndScalars) {
    const std::string dictionary = "{'shape': (), 'fortran_order': False, 'descr': '<f4'}";
    std::string text = "\x93NUMPY";
    text += {'\2', '\0', static_cast<char>(dictionary.size()), '\0', '\0', '\0'};
    text += dictionary + std::string("\x00\x00\x80\x3f"sv);
    const auto parsed = parse_npy(std::as_bytes(std::span(text)));
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_TRUE(parsed->shape.empty());
    EXPECT_EQ(parsed->values, std::vector<float>{1});
}

TEST(Npy, RefusesWhatItCannotReadAndSaysWhy) {
    const auto error = [](std::string_view dictionary, std::string_view array = kTwoFloats) {
        const auto parsed = parse_npy(npy(dictionary, array));
        EXPECT_FALSE(parsed) << dictionary;
        return parsed ? Error{} : parsed.error();
    };
    EXPECT_NE(error("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2), }").message.find("Fortran"), std::string::npos);
    EXPECT_NE(error("{'descr': '>f4', 'fortran_order': False, 'shape': (2,), }").message.find("big-endian"), std::string::npos);
    EXPECT_EQ(error("{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (2,), }").code, ErrorCode::invalid);
    EXPECT_EQ(error("{'descr': '<c8', 'fortran_order': False, 'shape': (1,), }").code, ErrorCode::invalid);
    EXPECT_EQ(error("{'descr': '<f4', 'fortran_order': False, 'shape': (3,), }").code, ErrorCode::truncated);
    EXPECT_EQ(error("{'descr': '<f4', 'fortran_order': False, 'shape': (1,), }").code, ErrorCode::trailing_bytes);
    EXPECT_EQ(error("{'descr': '<f4', 'fortran_order': False, 'shape': (-2,), }").code, ErrorCode::damaged);
    EXPECT_EQ(error("{'descr': '<f4', 'fortran_order': False, 'shape': (9000000000, 9000000000), }").code, ErrorCode::limit_exceeded);
    EXPECT_EQ(error("{'descr': '<f4', 'fortran_order': False}").code, ErrorCode::damaged);
    EXPECT_EQ(parse_npy(std::as_bytes(std::span("PK\3\4 something else", 20))).error().code, ErrorCode::bad_magic);
}

TEST(Npy, RefusesEveryTruncation) {
    const Bytes whole = npy("{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }", kTwoFloats);
    ASSERT_TRUE(parse_npy(whole));
    for (std::size_t n = 0; n < whole.size(); ++n) EXPECT_FALSE(parse_npy(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(n)))) << n;
}

TEST(Npy, WritesWhatItReads) {
    const TemporaryFolder folder;
    std::vector<float> values(700000);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = float(i) * 0.25f;
    write_npy(folder / "a.npy", {7, 100000}, values);
    const auto read = read_npy(folder / "a.npy");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->shape, (std::vector<std::int64_t>{7, 100000}));
    EXPECT_EQ(read->values, values);
    EXPECT_EQ(read_npy(folder / "b.npy").error().code, ErrorCode::missing);
}

}  // namespace
}  // namespace mien::io
