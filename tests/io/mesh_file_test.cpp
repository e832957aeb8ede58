#include "io/mesh_file.hpp"

#include <gtest/gtest.h>

#include <bit>

#include "core/byte_io.hpp"
#include "io/gltf.hpp"
#include "io/ply.hpp"
#include "tests/recordings.hpp"

namespace mien::io {
namespace {

using tests::recordings;

ByteView view(std::string_view text) { return std::as_bytes(std::span(text)); }

constexpr std::string_view kSquare =
    "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n"
    "property uchar red\nproperty float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 255 0 0\n1 0 0 255 1 0\n1 1 0 255 1 1\n0 1 -2.5 255 0 1\n4 0 1 2 3\n";

TEST(Ply, ReadsText) {
    const auto mesh = parse_ply(view(kSquare));
    ASSERT_TRUE(mesh) << mesh.error().message;
    ASSERT_EQ(mesh->positions.rows(), 4);
    EXPECT_EQ(mesh->positions(3, 2), -2.5f);
    EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(mesh->texcoord_triangles, mesh->triangles);
    EXPECT_EQ(mesh->texcoords[2], Vec2(1, 1));
}

Bytes binary_ply(bool big) {
    std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                        "_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                        "element face 1\nproperty list uchar uint vertex_index\nend_header\n";
    const auto u32 = [&](std::uint32_t v) {
        for (int i = 0; i < 4; ++i) bytes += static_cast<char>(v >> 8 * (big ? 3 - i : i));
    };
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 3.f}) u32(std::bit_cast<std::uint32_t>(x));
    bytes += '\3';
    for (const std::uint32_t i : {2u, 1u, 0u}) u32(i);
    return {view(bytes).begin(), view(bytes).end()};
}

TEST(Ply, ReadsBothByteOrders) {
    for (const bool big : {false, true}) {
        const auto mesh = parse_ply(binary_ply(big));
        ASSERT_TRUE(mesh) << mesh.error().message;
        EXPECT_EQ(mesh->positions(2, 1), 2);
        EXPECT_EQ(mesh->triangles, (std::vector<Triangle>{{2, 1, 0}}));
    }
}

TEST(Ply, EveryVertexThatIsNotFiniteIsNamed) {
    const auto mesh = parse_ply(view("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
                                     "nan 0 0\n0 0 0\n0 -inf 0\n0 0 inf\n"));
    ASSERT_FALSE(mesh);
    EXPECT_EQ(mesh.error().message, "vertices 0, 2-3 are not finite");
}

TEST(Ply, EveryBadLineIsNamedAndNoOther) {
    const std::string header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
                               "element face 5\nproperty list uchar int vertex_indices\nend_header\n";
    const auto mesh = parse_ply(view(header + "0 0 0\n1 0\n0 one 0\n\nnan 0 0\r\n1 2 3 4\n3 0 1 2\n3 0 1 7\n4 0 1 2\n2 0 1\n3 2 1 0\n"));
    ASSERT_FALSE(mesh);
    EXPECT_EQ(mesh.error().message, "vertex 3 is not finite; line 11: fewer numbers than the header tells of; line 12: \"one\" is not a number; "
                                    "line 15: more numbers than the header tells of; line 17: face 1 names vertex 7 of 5; line 18: fewer numbers than the header tells of; "
                                    "line 19: face 3 has fewer than three corners");
    EXPECT_EQ(mesh.error().code, ErrorCode::invalid);
    EXPECT_EQ(parse_ply(view(header + "0 0 0\n1 0 0\n")).error().code, ErrorCode::truncated);
    Bytes binary = binary_ply(false);
    for (const std::size_t corner : {0u, 2u}) binary[binary.size() - 12 + 4 * corner] = std::byte{9};
    EXPECT_EQ(parse_ply(binary).error().message, "face 0 names vertex 9 of 3");
}

TEST(Ply, RefusesEveryTruncationAndSurvivesDamage) {
    const Bytes whole = binary_ply(false);
    for (std::size_t n = 0; n < whole.size(); ++n) {
        EXPECT_FALSE(parse_ply(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(n)))) << n;
        for (const int value : {0, 255, int('9')}) {
            Bytes damaged = whole;
            damaged[n] = std::byte(value);
            const auto mesh = parse_ply(damaged);
            if (mesh) {
                EXPECT_LE(mesh->positions.rows(), 200);
            }
        }
    }
    EXPECT_EQ(parse_ply(view("ply\nformat ascii 1.0\nelement vertex 4000000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n")).error().code,
              ErrorCode::truncated);
    EXPECT_EQ(parse_ply(view("solid stl")).error().code, ErrorCode::bad_magic);
}

/// A GLB with one triangle, texture coordinates, one morph target and a node that doubles and shifts it.
Bytes glb() {
    ByteWriter binary;
    for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) binary.f32(x);  // positions, 36 bytes
    for (const float x : {0.f, 0.f, 1.f, 0.f, 0.f, 1.f}) binary.f32(x);                 // texture coordinates, 24
    for (const float x : {0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 1.f}) binary.f32(x);  // target, 36
    for (const int i : {0, 1, 2, 0}) binary.u16(static_cast<std::uint16_t>(i));         // indices, 8
    std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
 "nodes":[{"mesh":0,"scale":[2,2,2],"translation":[10,0,0]}],
 "meshes":[{"name":"Teeth","primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":3,"targets":[{"POSITION":2}]}],"extras":{"targetNames":["jawOpen"]}}],
 "buffers":[{"byteLength":104}],
 "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},{"buffer":0,"byteOffset":60,"byteLength":36},{"buffer":0,"byteOffset":96,"byteLength":6}],
 "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},
  {"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":3,"componentType":5123,"count":3,"type":"SCALAR"}]})";
    while (json.size() % 4) json += ' ';
    ByteWriter out;
    out.u32(0x46546c67), out.u32(2), out.u32(static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
    out.u32(static_cast<std::uint32_t>(json.size())), out.u32(0x4e4f534a), out.bytes(view(json));
    out.u32(static_cast<std::uint32_t>(binary.size())), out.u32(0x004e4942), out.bytes(binary.view());
    return out.take();
}

TEST(Gltf, ReadsMeshTransformAndMorphTarget) {
    const auto file = parse_gltf(glb());
    ASSERT_TRUE(file) << file.error().message;
    ASSERT_EQ(file->mesh.positions.rows(), 3);
    EXPECT_EQ(file->mesh.positions.row(1), (Eigen::RowVector3f(12, 0, 0)));
    EXPECT_EQ(file->mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
    EXPECT_EQ(file->mesh.texcoords[2], Vec2(0, 0));  // v counts from the bottom
    ASSERT_EQ(file->mesh.parts.size(), 1u);
    EXPECT_EQ(file->mesh.parts[0].surface, Surface::teeth);
    ASSERT_EQ(file->blendshapes.size(), 1u);
    EXPECT_EQ(file->blendshapes[0].name, "jawOpen");
    EXPECT_EQ(file->blendshapes[0].offsets.row(2), (Eigen::RowVector3f(0, 0, 2)));
}

TEST(Gltf, PointsThatAreNotFiniteAreNamed) {
    constexpr std::size_t kBinary = 104, kTexcoords = 36;
    const auto with_nan_at = [&](std::initializer_list<std::size_t> floats, std::size_t from) {
        Bytes bytes = glb();
        for (const std::size_t i : floats) bytes[bytes.size() - kBinary + from + 4 * i + 2] = std::byte{0xc0}, bytes[bytes.size() - kBinary + from + 4 * i + 3] = std::byte{0x7f};
        const auto file = parse_gltf(bytes);
        return file ? "" : file.error().message;
    };
    EXPECT_EQ(with_nan_at({4}, 0), "vertex 1 is not finite");
    EXPECT_EQ(with_nan_at({0, 1, 8}, 0), "vertices 0, 2 are not finite");
    EXPECT_EQ(with_nan_at({1, 2}, kTexcoords), "texture coordinates 0-1 are not finite");
}

TEST(Gltf, RefusesEveryTruncationAndSurvivesDamage) {
    const Bytes whole = glb();
    for (std::size_t n = 0; n < whole.size(); n += 3) {
        EXPECT_FALSE(parse_gltf(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(n)))) << n;
        for (const int value : {0, int('9'), int('}')}) {
            Bytes damaged = whole;
            damaged[n] = std::byte(value);
            const auto file = parse_gltf(damaged);
            if (file) {
                EXPECT_LE(file->mesh.positions.rows(), 100);
            }
        }
    }
}

TEST(Gltf, ReadsRealHeadsAndSaysWhyNot) {
    const auto folder = recordings();
    if (folder.empty() || !std::filesystem::exists(folder / "leeperrysmith_head/LeePerrySmith.glb")) GTEST_SKIP() << "no recordings here";
    const auto head = read_mesh(folder / "leeperrysmith_head/LeePerrySmith.glb");
    ASSERT_TRUE(head) << head.error().message;
    EXPECT_EQ(head->mesh.positions.rows(), 9279);
    EXPECT_EQ(head->mesh.triangles.size(), 17684u);
    EXPECT_TRUE(head->mesh.has_texcoords());
    const auto packed = read_mesh(folder / "facecap_glb/facecap.glb");
    ASSERT_FALSE(packed);
    EXPECT_NE(packed.error().message.find("EXT_meshopt_compression"), std::string::npos);
}

}  // namespace
}  // namespace mien::io
