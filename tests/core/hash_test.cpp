#include "core/hash.hpp"

#include <gtest/gtest.h>

#include "core/byte_io.hpp"

namespace mien {
namespace {

ByteView view(const char* text) { return std::as_bytes(std::span(text, std::char_traits<char>::length(text))); }

TEST(Hash, KnownDigests) {
    EXPECT_EQ(sha256(view("abc")).hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2
    EXPECT_EQ(crc32c(view("123456789")), 0xE3069283u);  // RFC 3720's check value
    EXPECT_EQ(crc32c(view("6789"), crc32c(view("12345"))), 0xE3069283u);
}

TEST(ByteIo, VarintsRoundTripInTheirShortestForm) {
    for (const std::uint64_t v : {0ull, 1ull, 127ull, 128ull, 16383ull, 16384ull, ~0ull, 1ull << 63}) {
        ByteWriter out;
        out.varint(v);
        ByteReader in(out.view());
        EXPECT_EQ(in.varint(), v);
        EXPECT_TRUE(in.ok() && in.at_end());
    }
    const std::byte overlong[] = {std::byte{0x80}, std::byte{0}};
    ByteReader in(overlong);
    in.varint();
    EXPECT_FALSE(in.ok());
}

TEST(ByteIo, ShortReadsStayFailed) {
    const std::byte bytes[] = {std::byte{1}, std::byte{2}};
    ByteReader in(bytes);
    EXPECT_EQ(in.u32(), 0u);
    EXPECT_FALSE(in.ok());
    EXPECT_EQ(in.u8(), 0u);
}

}  // namespace
}  // namespace mien
