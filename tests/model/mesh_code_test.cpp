#include "coding/mesh_code.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "coding/mesh_traversal.hpp"
#include "meshes.hpp"

namespace mien::coding {
namespace {

constexpr float kStep = 1.0f / 32;

void expect_connectivity(std::uint32_t V, const std::vector<Triangle>& triangles) {
    const auto back = decode_connectivity(encode_connectivity(V, triangles));
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->V, V);
    EXPECT_EQ(back->triangles, triangles);
}

/// Everything of a mesh through its blobs and back.
void expect_round_trip(const Mesh& mesh) {
    expect_connectivity(mesh.vertex_count(), mesh.triangles);
    Mesh back;
    back.triangles = mesh.triangles;
    const auto shape = decode_shape(encode_shape(mesh, kStep), mesh.vertex_count(), back);
    ASSERT_TRUE(shape.ok()) << shape.error().message;
    ASSERT_EQ(back.vertex_count(), mesh.vertex_count());
    for (Eigen::Index i = 0; i < mesh.positions.size(); ++i) {
        const float on_grid = kStep * float(std::lround(mesh.positions.data()[i] / kStep));
        ASSERT_EQ(back.positions.data()[i], on_grid) << i;
    }
    ASSERT_EQ(back.parts.size(), mesh.parts.size());
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        EXPECT_EQ(back.parts[p].name, mesh.parts[p].name);
        EXPECT_EQ(back.parts[p].surface, mesh.parts[p].surface);
        EXPECT_EQ(back.parts[p].first, mesh.parts[p].first);
        EXPECT_EQ(back.parts[p].count, mesh.parts[p].count);
    }
    if (!mesh.has_texcoords()) return;
    const auto texcoords = decode_texcoords(encode_texcoords(mesh), back);
    ASSERT_TRUE(texcoords.ok()) << texcoords.error().message;
    EXPECT_EQ(back.texcoord_triangles, mesh.texcoord_triangles);
    ASSERT_EQ(back.texcoords.size(), mesh.texcoords.size());
    for (std::size_t i = 0; i < mesh.texcoords.size(); ++i) EXPECT_LE((back.texcoords[i] - mesh.texcoords[i]).cwiseAbs().maxCoeff(), 0.5f / 65536);
}

Mesh with_seam(Mesh mesh) {
    // A second copy of the coordinates for every other triangle: each vertex lies on a seam.
    const auto VT = std::uint32_t(mesh.texcoords.size());
    for (std::uint32_t i = 0; i < VT; ++i) mesh.texcoords.push_back(mesh.texcoords[i] + Vec2(1.5f, -2.25f));
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 2)
        for (auto& corner : mesh.texcoord_triangles[t]) corner += VT;
    return mesh;
}

TEST(MeshCode, KeepsEveryVertexAndTriangleOrder) {
    expect_round_trip(sheet(12));
    for (unsigned seed = 0; seed < 8; ++seed) expect_round_trip(shuffled(sheet(9), seed));
}

TEST(MeshCode, KeepsSeamsPartsAndLooseVertices) {
    Mesh mesh = with_seam(sheet(7));
    mesh.parts = {{"skin", Surface::skin, 0, 30}, {"", Surface::teeth, 30, 0}, {"Zähne", Surface::mouth, 40, 32}};
    expect_round_trip(mesh);
    mesh.positions.conservativeResize(mesh.vertex_count() + 5, 3);
    mesh.positions.bottomRows(5).setConstant(-17.3f);
    expect_round_trip(mesh);
    mesh.parts.clear();
    expect_round_trip(shuffled(mesh, 3));
}

TEST(MeshCode, TakesNoTriangleOneTriangleAndNothing) {
    expect_round_trip({});
    Mesh mesh;
    mesh.positions = Points::Random(3, 3) * 80;
    expect_round_trip(mesh);
    for (const Triangle& t : {Triangle{0, 1, 2}, Triangle{2, 1, 0}, Triangle{1, 0, 2}}) {
        mesh.triangles = {t};
        expect_round_trip(mesh);
    }
}

TEST(MeshCode, TakesFansRepeatedAndDegenerateTriangles) {
    std::mt19937 random(5);
    Mesh mesh;
    mesh.positions = Points::Random(200, 3) * 60;
    for (std::uint32_t i = 2; i < 200; ++i) mesh.triangles.push_back({0, 1, i});       // all on one edge
    for (std::uint32_t i = 2; i < 199; ++i) mesh.triangles.push_back({i, i + 1, 0});   // a hub
    for (int i = 0; i < 20; ++i) mesh.triangles.push_back(mesh.triangles[random() % 100]);
    mesh.triangles.push_back({7, 7, 7});
    mesh.triangles.push_back({7, 8, 7});
    mesh.triangles.push_back({199, 0, 199});
    expect_round_trip(mesh);
    for (int i = 0; i < 300; ++i) mesh.triangles.push_back({std::uint32_t(random() % 200), std::uint32_t(random() % 200), std::uint32_t(random() % 200)});
    expect_round_trip(mesh);
}

TEST(MeshCode, KeepsTheMirrorAndSavesByIt) {
    Mesh mesh = sheet(24);
    // Built symmetrically, as faces are: the right half's diagonals run the other way.
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) {
        const auto [a, b, c] = mesh.triangles[t];
        if (a % 24 >= 12) mesh.triangles[t] = {a, b, c + 1}, mesh.triangles[t + 1] = {a, c + 1, c};
    }
    mesh.texcoord_triangles = mesh.triangles;
    std::mt19937 random(8);
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const std::uint32_t other = v / 24 * 24 + 23 - v % 24;
        mesh.mirror.push_back(other);
        if (other > v) mesh.positions.row(v) << float(v % 24) * 5 - 57.5f, float(v / 24) * 5, float(random() % 1000) / 300;
        else mesh.positions.row(v) = mesh.positions.row(other).cwiseProduct(Eigen::RowVector3f(-1, 1, 1));
    }
    expect_round_trip(mesh);
    const Bytes mirrored = encode_shape(mesh, kStep);
    Mesh back;
    back.triangles = mesh.triangles;
    ASSERT_TRUE(decode_shape(mirrored, mesh.vertex_count(), back).ok());
    EXPECT_EQ(back.mirror, mesh.mirror);
    Mesh plain = mesh;
    plain.mirror.clear();
    const Bytes alone = encode_shape(plain, kStep);
    EXPECT_LT(double(mirrored.size()), 0.75 * double(alone.size()));
    ASSERT_TRUE(decode_shape(alone, mesh.vertex_count(), back).ok());
    EXPECT_TRUE(back.mirror.empty());
    // A shape that is not what its mirror says pays little for it and is as exact.
    mesh.positions.col(2) += 7 * Eigen::VectorXf::Random(mesh.vertex_count());
    plain.positions = mesh.positions;
    expect_round_trip(mesh);
    EXPECT_LT(double(encode_shape(mesh, kStep).size()), 1.05 * double(encode_shape(plain, kStep).size()));
}

TEST(MeshCode, SpendsLittleOnOrderlyMeshes) {
    const Mesh mesh = sheet(64);
    EXPECT_LT(8.0 * double(encode_connectivity(mesh.vertex_count(), mesh.triangles).size()) / double(mesh.triangles.size()), 0.75) << "bits per triangle";
    EXPECT_LT(encode_texcoords(mesh).size(), 1500u) << "one corner in nine is new, and all are on a plane";
}

TEST(MeshCode, RefusesOrSurvivesDamage) {
    Mesh mesh = with_seam(shuffled(sheet(5), 1));
    mesh.parts = {{"skin", Surface::skin, 0, std::uint32_t(mesh.triangles.size())}};
    const std::uint32_t V = mesh.vertex_count();
    for_all_damage(encode_connectivity(V, mesh.triangles), [&](ByteView bytes, bool cut) {
        const auto back = decode_connectivity(bytes);
        EXPECT_FALSE(cut && back.ok()) << bytes.size();
        if (!back.ok()) return;
        for (const Triangle& t : back->triangles)
            for (const std::uint32_t v : t) EXPECT_LT(v, back->V);
    });
    for (std::uint32_t v = 0; v < V; ++v) mesh.mirror.push_back((v ^ 1u) < V ? v ^ 1u : v);
    for_all_damage(encode_shape(mesh, kStep), [&](ByteView bytes, bool cut) {
        Mesh back;
        back.triangles = mesh.triangles;
        const auto done = decode_shape(bytes, V, back);
        EXPECT_FALSE(cut && done.ok()) << bytes.size();
        if (!done.ok()) return;
        EXPECT_EQ(back.vertex_count(), V);
        EXPECT_TRUE(back.positions.allFinite());
        for (std::uint32_t v = 0; v < back.mirror.size(); ++v) EXPECT_EQ(back.mirror[back.mirror[v]], v);
        EXPECT_EQ(back.triangle_surfaces().size(), mesh.triangles.size());
    });
    for_all_damage(encode_texcoords(mesh), [&](ByteView bytes, bool cut) {
        Mesh back = mesh;
        const auto done = decode_texcoords(bytes, back);
        EXPECT_FALSE(cut && done.ok()) << bytes.size();
        if (!done.ok()) return;
        for (const Triangle& t : back.texcoord_triangles)
            for (const std::uint32_t vt : t) EXPECT_LT(vt, back.texcoords.size());
    });
}

TEST(MeshCode, RefusesMoreThanAMeshMayHave) {
    ByteWriter many;
    many.varint(1u << 23);
    many.varint(1);
    many.varint(0);
    EXPECT_EQ(decode_connectivity(many.view()).error().code, ErrorCode::limit_exceeded);
    ByteWriter no_vertex;
    no_vertex.varint(0);
    no_vertex.varint(1);
    no_vertex.varint(0);
    EXPECT_EQ(decode_connectivity(no_vertex.view()).error().code, ErrorCode::limit_exceeded);
    const Mesh mesh = sheet(3);
    Mesh back;
    EXPECT_EQ(decode_shape(encode_shape(mesh, kStep), 8, back).error().code, ErrorCode::mismatch);
}

TEST(Traversal, VisitsEveryVertexOnceAndLooksOnlyAtEarlierOnes) {
    const auto check = [](std::uint32_t V, const std::vector<Triangle>& triangles) {
        const Traversal walk = traverse(V, triangles);
        ASSERT_EQ(walk.steps.size(), V);
        std::vector<char> known(V, 0);
        for (std::size_t i = 0; i < V; ++i) {
            const TraversalStep& step = walk.steps[i];
            ASSERT_LT(step.vertex, V);
            ASSERT_FALSE(known[step.vertex]) << "twice";
            if (i == 0) EXPECT_EQ(step.nearest, step.vertex);
            else EXPECT_TRUE(known[step.nearest]);
            ASSERT_LE(step.first + step.count, walk.parallelograms.size());
            for (std::uint32_t p = step.first; p < step.first + step.count; ++p)
                EXPECT_TRUE(known[walk.parallelograms[p].a] && known[walk.parallelograms[p].b] && known[walk.parallelograms[p].c]);
            known[step.vertex] = 1;
        }
    };
    check(0, {});
    check(4, {});
    check(81, shuffled(sheet(9), 2).triangles);
    std::mt19937 random(8);
    std::vector<Triangle> nonsense;
    for (int i = 0; i < 500; ++i) nonsense.push_back({std::uint32_t(random() % 60), std::uint32_t(random() % 60), std::uint32_t(random() % 60)});
    check(90, nonsense);
}

TEST(Traversal, PredictsAPlaneExactlyFromItsSecondTriangleOn) {
    const Mesh mesh = sheet(9);
    const Traversal walk = traverse(81, mesh.triangles);
    std::vector<std::array<std::int32_t, 2>> values;
    for (int i = 0; i < 81; ++i) values.push_back({5 * (i % 9) - 3 * (i / 9) - 40, 7 * (i / 9) - 11});
    int wrong = 0;
    for (const TraversalStep& step : walk.steps) wrong += predict<2>(walk, step, values) != values[step.vertex];
    EXPECT_LE(wrong, 4);  // the first triangle, and a corner that no parallelogram reaches
}

}  // namespace
}  // namespace mien::coding
