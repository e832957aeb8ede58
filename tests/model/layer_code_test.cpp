#include "coding/layer_code.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <cmath>

#include "meshes.hpp"

namespace mien::coding {
namespace {

SparseRows some_rows() {
    SparseRows rows;
    rows.row_start = {0};
    const auto row = [&](std::initializer_list<SparseRows::Term> terms) {
        rows.terms.insert(rows.terms.end(), terms);
        rows.row_start.push_back(std::uint32_t(rows.terms.size()));
    };
    row({{0, 1.0f}});
    row({});
    row({{1, 0.3333f}, {2, 0.3333f}, {5, 0.3334f}});
    row({{4, 0.001f}, {5, 0.5f}});
    return rows;
}

std::vector<Site> some_sites() {
    return {Site::at_vertex(0), Site::at_vertex(1), Site::at_vertex(2), Site::at_vertex(3), {{0, 1, 2}, {0.25f, 0.5f, 0.25f}}, Site::at_vertex(3)};
}

TEST(BlendCode, KeepsSitesAndSharesAndTheSumOfEveryRow) {
    const SparseRows rows = some_rows();
    const auto back = decode_blend(encode_blend(some_sites(), rows), 4);
    ASSERT_TRUE(back.ok()) << back.error().message;
    ASSERT_EQ(back->sites.size(), 6u);
    EXPECT_EQ(back->sites[4].vertices[1], 1u);
    EXPECT_EQ(back->sites[4].weights[1], 0.5f);
    ASSERT_EQ(back->rows.row_start.size(), 5u);
    for (std::size_t j = 0; j < 4; ++j) {
        double want = 0, got = 0;
        for (std::uint32_t i = rows.row_start[j]; i < rows.row_start[j + 1]; ++i) want += rows.terms[i].share;
        for (std::uint32_t i = back->rows.row_start[j]; i < back->rows.row_start[j + 1]; ++i) got += back->rows.terms[i].share;
        EXPECT_NEAR(got, want, 0.5 / 255 + 1e-6) << j;
    }
    const auto* terms = back->rows.terms.data() + back->rows.row_start[2];
    ASSERT_EQ(back->rows.row_start[3] - back->rows.row_start[2], 3u);
    EXPECT_EQ(terms[0].column, 1u);
    EXPECT_EQ(terms[2].column, 5u);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(terms[i].share, 1.0 / 3, 1.0 / 255);
}

TEST(BlendCode, RefusesWhatDoesNotMixTheMarkersOfItsMesh) {
    const auto blend = [](std::initializer_list<unsigned> row) {
        ByteWriter out;
        out.varint(2);  // markers
        for (int m = 0; m < 2; ++m) {
            for (int i = 0; i < 3; ++i) out.varint(0);
            for (float w : {1.f, 0.f, 0.f}) out.f32(w);
        }
        out.varint(1);  // vertices
        for (const unsigned value : row) out.u8(std::uint8_t(value));
        return decode_blend(out.view(), 1);
    };
    EXPECT_TRUE(blend({2, 0, 100, 1, 155}).ok());
    EXPECT_FALSE(blend({2, 0, 101, 1, 155}).ok()) << "more than all";
    EXPECT_FALSE(blend({1, 2, 100}).ok()) << "no such marker";
    EXPECT_FALSE(blend({2, 1, 100, 0, 100}).ok()) << "one marker twice";
    EXPECT_FALSE(blend({1, 0, 0}).ok()) << "nothing of it";
    EXPECT_FALSE(blend({1, 0, 9, 7}).ok()) << "bytes behind";
    EXPECT_FALSE(decode_blend(encode_blend(some_sites(), some_rows()), 3).ok()) << "another mesh";
}

TEST(BlendshapeCode, KeepsNamesAndOffsetsToTheGrid) {
    const Mesh mesh = shuffled(sheet(6), 4);
    std::vector<Blendshape> targets;
    for (const char* name : {"JawOpen", "", "smile_ÄÖ"}) targets.push_back({name, Points::Random(36, 3) * 12});
    constexpr float kStep = 1.0f / 64;
    const auto back = decode_blendshapes(encode_blendshapes(targets, mesh.triangles, kStep), 36, mesh.triangles);
    ASSERT_TRUE(back.ok()) << back.error().message;
    ASSERT_EQ(back->size(), 3u);
    for (std::size_t t = 0; t < 3; ++t) {
        EXPECT_EQ((*back)[t].name, targets[t].name);
        EXPECT_LE(((*back)[t].offsets - targets[t].offsets).cwiseAbs().maxCoeff(), kStep / 2);
    }
    const auto none = decode_blendshapes(encode_blendshapes({}, mesh.triangles, kStep), 36, mesh.triangles);
    ASSERT_TRUE(none.ok());
    EXPECT_TRUE(none->empty());
}

TEST(EyeCode, KeepsBothOneOrNoEye) {
    for (int which = 0; which < 4; ++which) {
        std::array<std::optional<Ball>, 2> eyes;
        if (which & 1) eyes[0] = Ball{{-31, 0.5f, 80}, {0, 1, 2, 5, 9}};
        if (which & 2) eyes[1] = Ball{{31, 0.5f, 80}, {3}};
        const auto back = decode_eyes(encode_eyes(eyes), 10);
        ASSERT_TRUE(back.ok());
        for (std::size_t side = 0; side < 2; ++side) {
            ASSERT_EQ((*back)[side].has_value(), eyes[side].has_value());
            if (!eyes[side]) continue;
            EXPECT_EQ((*back)[side]->centre, eyes[side]->centre);
            EXPECT_EQ((*back)[side]->vertices, eyes[side]->vertices);
        }
        EXPECT_EQ(decode_eyes(encode_eyes(eyes), 9).ok(), !(which & 1)) << "vertex 9 is not there";
    }
}

Contact some_lips() { return {{{4, 9}, {3, 8}}, {{2, 1}, {3, 0.25f}, {4, 1.0f / 127}, {8, -0.5f}, {9, -1}}}; }

TEST(ContactCode, KeepsPairsAndHolds) {
    const Contact lips = some_lips();
    const auto back = decode_contact(encode_contact(lips), 10);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->pairs, lips.pairs);
    ASSERT_EQ(back->members.size(), lips.members.size());
    for (std::size_t i = 0; i < lips.members.size(); ++i) {
        EXPECT_EQ(back->members[i].vertex, lips.members[i].vertex);
        EXPECT_NEAR(back->members[i].hold, lips.members[i].hold, 0.5 / 127 + 1e-6);
    }
    EXPECT_FALSE(decode_contact(encode_contact(lips), 9).ok()) << "vertex 9 is not there";
}

TEST(ContactCode, RefusesHoldsOfNothingAndTooManyPairs) {
    const auto one = [](unsigned pairs, unsigned hold) {
        ByteWriter out;
        out.varint(pairs);
        for (unsigned i = 0; i < 2 * pairs; ++i) out.varint(0);
        out.varint(1);
        out.varint(5);
        out.u8(std::uint8_t(hold));
        return out.take();
    };
    EXPECT_TRUE(decode_contact(one(1, 1), 6).ok());
    EXPECT_TRUE(decode_contact(one(kMaxContactPairs, 0x81), 6).ok());
    EXPECT_FALSE(decode_contact(one(1, 0), 6).ok());
    EXPECT_FALSE(decode_contact(one(1, 0x80), 6).ok()) << "more than the whole push";
    EXPECT_FALSE(decode_contact(one(0, 1), 6).ok());
    EXPECT_FALSE(decode_contact(one(kMaxContactPairs + 1, 1), 6).ok());
}

Lid some_lid() { return {{31.5f, -2, 70}, {{0, 1, 0, 0}, {3, 1.625f, 1, 0.25f}, {4, 3.984375f, 0.5f, 1}, {9, 0, 1.0f / 255, 0.5f}}}; }

TEST(LidCode, KeepsSharesAndHolds) {
    const Lid lid = some_lid();
    const auto back = decode_lid(encode_lid(lid), 10);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->centre, lid.centre);
    ASSERT_EQ(back->members.size(), lid.members.size());
    for (std::size_t i = 0; i < lid.members.size(); ++i) {
        EXPECT_EQ(back->members[i].vertex, lid.members[i].vertex);
        EXPECT_EQ(back->members[i].share, lid.members[i].share);
        EXPECT_NEAR(back->members[i].weight, lid.members[i].weight, 0.5 / 255 + 1e-6);
        EXPECT_NEAR(back->members[i].hold, lid.members[i].hold, 0.5 / 255 + 1e-6);
    }
    EXPECT_FALSE(decode_lid(encode_lid(lid), 9).ok()) << "vertex 9 is not there";
}

TEST(LidCode, RefusesWhatIsNoLid) {
    const auto one = [](float centre, unsigned members) {
        ByteWriter out;
        for (int c = 0; c < 3; ++c) out.f32(centre);
        out.varint(members);
        out.varint(5);
        for (int i = 0; i < 3; ++i) out.u8(255);
        return out.take();
    };
    EXPECT_TRUE(decode_lid(one(0, 1), 6).ok());
    EXPECT_FALSE(decode_lid(one(0, 1), 5).ok()) << "vertex 5 is not there";
    EXPECT_FALSE(decode_lid(one(0, 7), 6).ok()) << "more members than vertices";
    EXPECT_FALSE(decode_lid(one(1e7f, 1), 6).ok());
    EXPECT_FALSE(decode_lid(one(std::numeric_limits<float>::quiet_NaN(), 1), 6).ok());
}

TEST(LayerCode, RefusesOrSurvivesDamage) {
    for_all_damage(encode_lid(some_lid()), [](ByteView bytes, bool cut) {
        const auto back = decode_lid(bytes, 10);
        EXPECT_FALSE(cut && back.ok()) << bytes.size();
        if (!back.ok()) return;
        for (const auto& member : back->members) {
            EXPECT_LT(member.vertex, 10u);
            EXPECT_LE(member.weight, 1);
        }
    });
    for_all_damage(encode_contact(some_lips()), [](ByteView bytes, bool cut) {
        const auto back = decode_contact(bytes, 10);
        EXPECT_FALSE(cut && back.ok()) << bytes.size();
        if (!back.ok()) return;
        for (const auto& pair : back->pairs) EXPECT_LT(std::max(pair[0], pair[1]), 10u);
        for (const auto& member : back->members) EXPECT_LT(member.vertex, 10u);
    });
    for_all_damage(encode_blend(some_sites(), some_rows()), [](ByteView bytes, bool cut) {
        const auto back = decode_blend(bytes, 4);
        EXPECT_FALSE(cut && back.ok()) << bytes.size();
        if (!back.ok()) return;
        for (const auto& term : back->rows.terms) EXPECT_LT(term.column, back->sites.size());
        EXPECT_EQ(back->rows.row_start.back(), back->rows.terms.size());
    });
    const Mesh mesh = sheet(4);
    const std::vector<Blendshape> targets = {{"a", Points::Random(16, 3) * 5}, {"b", Points::Random(16, 3)}};
    for_all_damage(encode_blendshapes(targets, mesh.triangles, 1.0f / 64), [&](ByteView bytes, bool cut) {
        const auto back = decode_blendshapes(bytes, 16, mesh.triangles);
        EXPECT_FALSE(cut && back.ok()) << bytes.size();
        if (!back.ok()) return;
        for (const Blendshape& target : *back) {
            EXPECT_EQ(target.offsets.rows(), 16);
            EXPECT_TRUE(target.offsets.allFinite());
        }
    });
    const std::array<std::optional<Ball>, 2> eyes = {Ball{{-31, 0, 80}, {0, 1, 2, 5}}, Ball{{31, 0, 80}, {8, 9}}};
    for_all_damage(encode_eyes(eyes), [](ByteView bytes, bool cut) {
        const auto back = decode_eyes(bytes, 10);
        EXPECT_FALSE(cut && back.ok()) << bytes.size();
        if (!back.ok()) return;
        for (const auto& eye : *back) {
            if (!eye) continue;
            for (const std::uint32_t v : eye->vertices) EXPECT_LT(v, 10u);
        }
    });
}

}  // namespace
}  // namespace mien::coding
