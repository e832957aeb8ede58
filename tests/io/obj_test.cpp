#include "io/obj.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "io/file.hpp"
#include "io/surface_names.hpp"
#include "tests/recordings.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::io {
namespace {

using tests::recordings;
using tests::TemporaryFolder;

TEST(Obj, PolygonsBecomeFansInPlaceAndIndicesMayCountBack) {
    const auto mesh = parse_obj(
        "\xef\xbb\xbf# a comment\r\nv 0 0 0\r\nv 1 0 0\r\nv +1 1.5e0 0\r\nv 0 1 -2\r\n"
        "vt 0 0\r\nvt 1 0\r\nvt 1 1\r\nvt 0 1\r\n"
        "f 1/1/9 2/2/9 3/3/9 4/4/9\r\nf -1/-1 -2/-2 \\\r\n -3/-3\r\n");
    ASSERT_TRUE(mesh) << mesh.error().message;
    ASSERT_EQ(mesh->positions.rows(), 4);
    EXPECT_EQ(mesh->positions(2, 1), 1.5f);
    EXPECT_EQ(mesh->positions(3, 2), -2.0f);
    EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}}));
    EXPECT_EQ(mesh->texcoord_triangles, mesh->triangles);
    EXPECT_TRUE(mesh->parts.empty());
}

TEST(Obj, NamesTellTheSurface) {
    const auto mesh = parse_obj(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
        "usemtl M_Face\nf 1 2 3\nusemtl M_GumsTongue\nf 1 2 3\nf 1 2 3\nusemtl M_ScleraLeft\nf 1 2 3\nusemtl lambert1\ng eyelashes\nf 1 2 3\n");
    ASSERT_TRUE(mesh) << mesh.error().message;
    ASSERT_EQ(mesh->parts.size(), 4u);
    EXPECT_EQ(mesh->parts[1].name, "M_GumsTongue");
    EXPECT_EQ(mesh->parts[1].first, 1u);
    EXPECT_EQ(mesh->parts[1].count, 2u);
    EXPECT_EQ(mesh->triangle_surfaces(),
              (std::vector<Surface>{Surface::skin, Surface::mouth, Surface::mouth, Surface::eye, Surface::lashes}));
}

TEST(Obj, FacesWithoutTextureShareOnePointThatCoversNothing) {
    const auto mesh = parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 3//1 2//1 1//1\n");
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->texcoords.size(), 4u);
    EXPECT_EQ(mesh->texcoord_triangles[1], (Triangle{3, 3, 3}));
}

TEST(Obj, RefusesNonsenseByLine) {
    for (const auto& [text, line] : std::initializer_list<std::pair<const char*, const char*>>{
             {"v 0 0\n", "line 1"}, {"v 0 0 nan\n", "line 1"}, {"v 0 0 1e999\n", "line 1"}, {"v 0 0 0\nf 1 1 2\n", "line 2"},
             {"v 0 0 0\nf 1 1\n", "line 2"}, {"v 0 0 0\nf 0 1 1\n", "line 2"}, {"v 0 0 0\nf -2 1 1\n", "line 2"}, {"v 0 0 0\nf 1/1 1/1 1/1\n", "line 2"},
             {"v 0 0 0\nf a b c\n", "line 2"}, {"v 0 0 0\nf 99999999999999999999 1 1\n", "line 2"}}) {
        const auto mesh = parse_obj(text);
        ASSERT_FALSE(mesh) << text;
        EXPECT_EQ(mesh.error().code, ErrorCode::invalid) << text;
        EXPECT_TRUE(mesh.error().message.starts_with(line)) << mesh.error().message;
    }
}

TEST(Obj, EveryVertexThatIsNotFiniteIsNamed) {
    const std::string text = "v 0 0 0\n# one\nv nan 0 0\nv 0 inf 0\nv 0 0 0\nv 0 0 1e999\nf 1 2 3\n";
    for (const Error& error : {parse_obj(text).error(), parse_obj_positions(text).error()}) EXPECT_EQ(error.message, "line 3: vertices 1-2, 4 are not finite");
    EXPECT_EQ(parse_obj_positions("v 0 0 0\nv 0 0 zero\n").error().message, "line 2: vertex 1 has no three numbers");
}

TEST(Obj, EveryBadLineIsNamedAndNoOther) {
    const std::string text = "v 0 0 0\nv 0 zero 0\nv 0 0 1\nv nan 0 0\nvt 0 0\nvt x\nf 1 2 3\nf 1 2 9\nf 1/2 2/1 3/5\nf 1 2\nf 4 3 2\n";
    const Error error = parse_obj(text).error();
    EXPECT_EQ(error.message, "line 4: vertex 3 is not finite; line 2: vertex 1 has no three numbers; line 6: texture coordinate 1 has no finite numbers; "
                             "line 8: vertex 9 does not exist (4 so far); line 9: texture coordinate 5 does not exist (2 so far); line 10: a face has fewer than three corners");
    EXPECT_EQ(error.code, ErrorCode::invalid);
    EXPECT_EQ(parse_obj_positions(text).error().message, "line 4: vertex 3 is not finite; line 2: vertex 1 has no three numbers");
    // Who has named twenty has named enough.
    std::string many;
    for (int i = 0; i < 57; ++i) many += "v 0 0\n";
    const std::string message = parse_obj(many).error().message;
    EXPECT_NE(message.find("line 20:"), std::string::npos) << message;
    EXPECT_EQ(message.find("line 21:"), std::string::npos) << message;
    EXPECT_TRUE(message.ends_with("; and 37 more")) << message;
}

TEST(Obj, WritesWhatItReads) {
    Mesh mesh;
    mesh.positions = Points::Random(5, 3) * 100;
    mesh.triangles = {{0, 1, 2}, {2, 3, 4}, {4, 0, 1}};
    mesh.texcoords = {{0.1f, 0.2f}, {0.3f, 0.4f}, {0.5f, 1.0f / 3}};
    mesh.texcoord_triangles = {{0, 1, 2}, {2, 1, 0}, {1, 1, 2}};
    mesh.parts = {{"face", Surface::skin, 0, 1}, {"front", Surface::teeth, 1, 1}, {"eye_r", Surface::cornea, 2, 1}};
    const TemporaryFolder folder;
    write_obj(folder / "a.obj", mesh, 10);
    const auto read = read_obj(folder / "a.obj");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE((read->positions * 10).isApprox(mesh.positions, 1e-6f));
    EXPECT_EQ(read->triangles, mesh.triangles);
    EXPECT_EQ(read->texcoords, mesh.texcoords);
    EXPECT_EQ(read->texcoord_triangles, mesh.texcoord_triangles);
    ASSERT_EQ(read->parts.size(), 3u);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(read->parts[std::size_t(i)].name, mesh.parts[std::size_t(i)].name);
        EXPECT_EQ(read->parts[std::size_t(i)].surface, mesh.parts[std::size_t(i)].surface);
        EXPECT_EQ(read->parts[std::size_t(i)].first, mesh.parts[std::size_t(i)].first);
    }
}

TEST(Obj, ReadsTheIctHead) {
    const auto path = recordings() / "ict_facekit/generic_neutral_mesh.obj";
    if (recordings().empty() || !std::filesystem::exists(path)) GTEST_SKIP() << "no recordings here";
    const auto text = read_text(path);
    ASSERT_TRUE(text);
    const auto start = std::chrono::steady_clock::now();
    const auto mesh = parse_obj(*text);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    RecordProperty("milliseconds", std::to_string(took.count() * 1e3));
    std::printf("parsed in %.1f ms\n", took.count() * 1e3);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_EQ(mesh->positions.rows(), 26719);
    EXPECT_EQ(mesh->texcoords.size(), 28911u);
    EXPECT_EQ(mesh->triangles.size(), 52220u);
    EXPECT_EQ(mesh->parts.size(), 12u);
    EXPECT_EQ(parse_obj_positions(*text)->rows(), 26719);
}

}  // namespace
}  // namespace mien::io
