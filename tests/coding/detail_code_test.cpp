#include "coding/detail_code.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/byte_io.hpp"

namespace mien::coding {
namespace {

Shell some_shell() { return {{Site::at_vertex(3), {{4, 2, 9}, {0.5f, 0.25f, 0.25f}}, Site::at_vertex(0)}, {1, 2, 3, 8}}; }

Bytes bytes_of(std::initializer_list<unsigned> values) {
    Bytes bytes;
    for (const unsigned v : values) bytes.push_back(std::byte(v));
    return bytes;
}

TEST(ShellCode, IsTheBytesOfItsDescription) {
    const Bytes expected = bytes_of({3, 3, 0, 0, 4, 3, 10, 0x80, 0x10, 0x80, 0x10, 0, 0, 0, 2, 1, 2, 4, 0});
    EXPECT_EQ(encode_shell(some_shell()), expected);
    const auto back = decode_shell(expected, 10);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->fixed, some_shell().fixed);
    EXPECT_EQ(back->sites[1].vertices[1], 2u);
    EXPECT_EQ(back->sites[1].weights[0], 0.5f);
    EXPECT_EQ(back->sites[2].weights[0], 1);
    EXPECT_FALSE(decode_shell(expected, 9).ok()) << "vertex 9 is not there";
    for (std::size_t size = 0; size < expected.size(); ++size) EXPECT_FALSE(decode_shell(ByteView(expected).first(size), 10).ok()) << size;
    EXPECT_FALSE(decode_shell(bytes_of({2, 0, 0, 0, 1, 0, 0, 0}), 10).ok()) << "two markers span nothing";
    ByteWriter many;
    many.varint(kMaxDetailMarkers + 1);
    EXPECT_EQ(decode_shell(many.view(), 10).error().code, ErrorCode::limit_exceeded);
}

MarkerDomain some_domain() {
    MarkerDomain domain;
    domain.reach = 30;
    domain.triangles = {{0, 1, 2}, {2, 1, 3}};
    domain.terms = 3;
    for (int m = 0; m < 4; ++m) {
        auto& row = domain.axes.emplace_back();
        for (int k = 0; k < MarkerDomain::kAxes; ++k) row[std::size_t(k)] = m == 2 ? 0 : std::ldexp(std::sin(float(3 * m + k)), 3 * m - 4);
        for (int row_of = 0; row_of < 3; ++row_of)
            for (int column = 0; column <= row_of; ++column) domain.factors.push_back(row_of == column ? 1.0f - 0.33f * float(m) : 0.2f * float(row_of - m));
    }
    return domain;
}

TEST(MarkerDomainCode, KeepsExtentsRoundedUp) {
    MarkerDomain domain = some_domain();
    const Bytes without = encode_marker_domain(domain);
    domain.extents = {2.0f, 0, 3.1f, 1e9f};
    const Bytes bytes = encode_marker_domain(domain);
    const auto back = decode_marker_domain(bytes, 4);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->extents, (std::vector<float>{2.0f, kExtentStep, 3.125f, kMaxExtent}));
    EXPECT_EQ(back->terms, 3);
    const auto none = decode_marker_domain(without, 4);
    ASSERT_TRUE(none.ok());
    EXPECT_TRUE(none->extents.empty());
    EXPECT_EQ(none->axes, back->axes);
    EXPECT_EQ(none->factors, back->factors);
}

TEST(MarkerDomainCode, KeepsTrianglesAxesAndFactors) {
    const MarkerDomain domain = some_domain();
    const Bytes bytes = encode_marker_domain(domain);
    const auto back = decode_marker_domain(bytes, 4);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->triangles, domain.triangles);
    EXPECT_EQ(back->reach, 30);
    for (std::size_t m = 0; m < 4; ++m) {
        float most = 0;
        for (const float a : domain.axes[m]) most = std::max(most, std::abs(a));
        for (std::size_t k = 0; k < 10; ++k) EXPECT_NEAR(back->axes[m][k], domain.axes[m][k], most / 4096);
    }
    for (std::size_t i = 0; i < domain.factors.size(); ++i) EXPECT_NEAR(back->factors[i], domain.factors[i], kFactorStep / 2 + 1e-6f) << i;
    EXPECT_FALSE(decode_marker_domain(bytes, 5).ok()) << "of as many markers as the shell has";
}

TEST(MarkerDomainCode, RefusesTrianglesAndNumbersThatCannotBe) {
    MarkerDomain domain = some_domain();
    domain.triangles[1] = {2, 2, 3};
    EXPECT_FALSE(decode_marker_domain(encode_marker_domain(domain), 4).ok()) << "a corner twice";
    const Bytes good = encode_marker_domain(some_domain());
    for (const float reach : {0.0f, -1.0f, 2000.0f, std::numeric_limits<float>::quiet_NaN()}) {
        ByteWriter out;
        out.f32(reach);
        out.bytes(ByteView(good).subspan(4));
        EXPECT_FALSE(decode_marker_domain(out.view(), 4).ok()) << reach;
    }
    for (std::size_t size = 0; size < good.size(); ++size) {
        const auto cut = decode_marker_domain(ByteView(good).first(size), 4);
        if (!cut.ok()) continue;
        for (const auto& row : cut->axes)
            for (const float a : row) EXPECT_TRUE(std::isfinite(a));
        for (std::size_t m = 0; m < 4; ++m)
            for (const std::size_t diagonal : {0u, 2u, 5u}) EXPECT_GE(cut->factors[6 * m + diagonal], kFactorStep);
    }
}

TEST(DetailMapCode, IsTheBytesOfItsDescription) {
    const MapHead head{3, 1, 0.5f, 2, {1 << 14, 0, 0, 0, 0, -1, 0, 0, 0}};
    const Bytes expected = bytes_of({3, 1, 0, 0, 0, 0x3f, 2, 0, 0x40, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 5, 0xfe, 0xab});
    EXPECT_EQ(encode_map(head, {{5, -2}, bytes_of({0xab})}), expected);
    const auto back = decode_map(expected);
    ASSERT_TRUE(back.ok());
    EXPECT_EQ(back->head.rotation, head.rotation);
    EXPECT_EQ(back->first.lift[1], -2);
    EXPECT_EQ(back->first.coded, bytes_of({0xab}));
    for (std::size_t size = 0; size < 27; ++size) EXPECT_FALSE(decode_map(ByteView(expected).first(size)).ok()) << size;
    const auto with = [&](std::size_t at, unsigned value) {
        Bytes bytes = expected;
        bytes[at] = std::byte(value);
        return decode_map(bytes).ok();
    };
    EXPECT_FALSE(with(0, 2)) << "channels";
    EXPECT_FALSE(with(1, 4)) << "order";
    EXPECT_FALSE(with(5, 0x7f)) << "step";
    EXPECT_FALSE(with(5, 0xbf)) << "step below zero";
    EXPECT_FALSE(with(6, 0)) << "stages";
    EXPECT_FALSE(with(6, kMaxStages + 1)) << "stages";
    const Bytes refinement = encode_refinement(3, {{1, 2}, bytes_of({7})});
    EXPECT_EQ(refinement, bytes_of({3, 1, 2, 7}));
    EXPECT_TRUE(decode_refinement(refinement, 3).ok());
    EXPECT_FALSE(decode_refinement(refinement, 2).ok()) << "out of order";
    EXPECT_FALSE(decode_refinement(ByteView(refinement).first(2), 3).ok());
}

}  // namespace
}  // namespace mien::coding
