#include "coding/mesh_code.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "coding/integer_model.hpp"
#include "coding/mesh_traversal.hpp"
#include "coding/mirror_code.hpp"
#include "coding/triangle_coder.hpp"
#include "coding/vertex_values.hpp"

namespace mien::coding {
namespace {

// Of the format (docs/format-model.md); the same bounds as protocol/limits.hpp, which this room may not see.
constexpr std::uint32_t kMaxVertices = 1u << 22;
constexpr std::uint32_t kMaxTriangles = 1u << 23;
constexpr std::size_t kMaxParts = 4096;     // film heads have some dozens
constexpr std::size_t kMaxPartName = 256;   // bytes
constexpr int kLimit = 255;                 // of the adaptive counts while coding texture corners

Error damaged(const char* what) { return {ErrorCode::damaged, std::string("the ") + what + " blob does not decode"}; }

void write_coded(ByteWriter& out, RangeEncoder& coder) {
    const Bytes bytes = coder.finish();
    out.varint(bytes.size());
    out.bytes(bytes);
}

constexpr std::uint8_t kMirrored = 1;

std::vector<std::array<std::int32_t, 3>> on_grid(PointsRef points, float step) {
    std::vector<std::array<std::int32_t, 3>> values(std::size_t(points.rows()));
    for (std::size_t i = 0; i < values.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double v = std::round(double(points(Eigen::Index(i), c)) / step);
            assert(std::abs(v) <= kMaxVertexValue);
            values[i][std::size_t(c)] = std::int32_t(v);
        }
    return values;
}

}  // namespace

Bytes encode_connectivity(std::uint32_t V, const std::vector<Triangle>& triangles) {
    ByteWriter out;
    out.varint(V);
    out.varint(triangles.size());
    RangeEncoder coder;
    TriangleCoder walk(coder, V);
    for (Triangle t : triangles) walk.code(t);
    write_coded(out, coder);
    return out.take();
}

Result<Connectivity> decode_connectivity(ByteView bytes) {
    ByteReader in(bytes);
    Connectivity mesh;
    const std::uint64_t V = in.varint(), T = in.varint();
    if (in.ok() && (V > kMaxVertices || T > kMaxTriangles || (T > 0 && V == 0)))
        return Error{ErrorCode::limit_exceeded, "the connectivity blob announces more vertices or triangles than a mesh may have"};
    const ByteView coded = in.bytes(in.varint());
    if (!in.ok() || !in.at_end()) return damaged("connectivity");
    mesh.V = std::uint32_t(V);
    RangeDecoder coder(coded);
    TriangleCoder walk(coder, mesh.V);
    // No allocation for what is only announced: a triangle costs at least a small fraction of a bit.
    mesh.triangles.reserve(std::min<std::uint64_t>(T, 65536));
    for (std::uint64_t t = 0; t < T; ++t) {
        Triangle triangle{};
        walk.code(triangle);
        if (coder.failed()) return damaged("connectivity");
        mesh.triangles.push_back(triangle);
    }
    if (!coder.complete()) return damaged("connectivity");
    return mesh;
}

Bytes encode_shape(const Mesh& mesh, float step) {
    const std::uint32_t V = mesh.vertex_count();
    ByteWriter out;
    out.varint(V);
    out.f32(step);
    out.varint(mesh.parts.size());
    for (const MeshPart& part : mesh.parts) {
        out.text(part.name.substr(0, kMaxPartName));
        out.u8(std::uint8_t(part.surface));
        out.varint(part.first);
        out.varint(part.count);
    }
    out.u8(mesh.mirror.empty() ? 0 : kMirrored);
    RangeEncoder coder;
    if (!mesh.mirror.empty()) {
        std::vector<std::uint32_t> mirror = mesh.mirror;
        code_mirror(coder, vertex_neighbours(V, mesh.triangles), mirror);
    }
    auto values = on_grid(mesh.positions, step);
    VertexValueModel<3> model;
    code_values<3>(coder, model, traverse(V, mesh.triangles), values, mesh.mirror);
    write_coded(out, coder);
    return out.take();
}

Result<void> decode_shape(ByteView bytes, std::uint32_t V, Mesh& mesh) {
    ByteReader in(bytes);
    const std::uint64_t announced = in.varint();
    const float step = in.f32();
    const std::uint64_t parts = in.varint();
    if (!in.ok()) return damaged("shape");
    if (announced != V) return Error{ErrorCode::mismatch, "the shape blob and the connectivity blob disagree on the number of vertices"};
    if (!(step > 1e-9f && step < 1e6f)) return damaged("shape");
    if (parts > kMaxParts) return Error{ErrorCode::limit_exceeded, "the shape blob announces too many parts"};
    mesh.parts.clear();
    std::uint64_t next = 0;
    for (std::uint64_t i = 0; i < parts; ++i) {
        MeshPart part;
        part.name = in.text(kMaxPartName);
        const std::uint8_t surface = in.u8();
        const std::uint64_t first = in.varint(), count = in.varint();
        if (!in.ok() || surface > std::uint8_t(Surface::other) || first < next || count > mesh.triangles.size() ||
            first > mesh.triangles.size() - count)
            return damaged("shape");
        part.surface = Surface(surface);
        part.first = std::uint32_t(first);
        part.count = std::uint32_t(count);
        next = first + count;
        mesh.parts.push_back(std::move(part));
    }
    const std::uint8_t flags = in.u8();
    const ByteView coded = in.bytes(in.varint());
    if (!in.ok() || !in.at_end() || flags > kMirrored) return damaged("shape");
    RangeDecoder coder(coded);
    mesh.mirror.clear();
    if (flags & kMirrored) code_mirror(coder, vertex_neighbours(V, mesh.triangles), mesh.mirror);
    if (coder.failed()) return damaged("shape");
    std::vector<std::array<std::int32_t, 3>> values(V);
    VertexValueModel<3> model;
    code_values<3>(coder, model, traverse(V, mesh.triangles), values, mesh.mirror);
    if (!coder.complete()) return damaged("shape");
    mesh.positions.resize(V, 3);
    for (std::uint32_t v = 0; v < V; ++v)
        for (int c = 0; c < 3; ++c) mesh.positions(v, c) = step * float(values[v][std::size_t(c)]);
    return {};
}

namespace {

constexpr float kTexcoordStep = 1.0f / 65536;

/// Texture triangles beside position triangles: a corner keeps the coordinate last used with its vertex, takes the next
/// unused one, the one with the vertex's own number, or a number.
template <class Coder>
void code_texture_corners(Coder& coder, const std::vector<Triangle>& triangles, std::uint32_t V, std::uint32_t VT,
                          std::vector<Triangle>& texture) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    IntegerModel kinds(std::vector<int>{4, 16, 8}, 1, 1, kLimit), numbers(std::vector<int>{1, 16}, 1, 1, kLimit);
    std::vector<std::uint32_t> last(V, kUnused);
    std::uint32_t next = 0, before = 0;
    int last_kind = 0, older_kind = 0, number_level = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t v = triangles[t][std::size_t(i)];
            std::uint32_t& vt = texture[t][std::size_t(i)];
            std::int32_t kind = 3;
            if constexpr (!Coder::kDecodes) kind = vt == last[v] ? 0 : vt == v ? 1 : vt == next ? 2 : 3;
            kinds.code(coder, kind, {{last_kind, last_kind * 4 + older_kind, (last[v] == kUnused) * 4 + last_kind}, 0, 0});
            if (kind < 0 || kind > 3 || (kind == 0 && last[v] == kUnused)) return coder.fail();
            std::int32_t delta = 0;
            if (kind == 3) {
                if constexpr (!Coder::kDecodes) delta = std::int32_t(std::int64_t(vt) - before);
                numbers.code(coder, delta, {{0, number_level}, 0, 0});
                number_level = magnitude_level(std::uint32_t(std::abs(delta)), 16);
            }
            if (Coder::kDecodes)
                vt = kind == 0 ? last[v] : kind == 1 ? v : kind == 2 ? next : std::uint32_t(std::int64_t(before) + delta);
            if (vt >= VT || coder.failed()) {
                vt = 0;
                return coder.fail();
            }
            last[v] = vt;
            before = vt;
            next = std::max(next, vt + 1);
            older_kind = last_kind;
            last_kind = kind;
        }
}

}  // namespace

Bytes encode_texcoords(const Mesh& mesh) {
    const auto VT = std::uint32_t(mesh.texcoords.size());
    ByteWriter out;
    out.varint(VT);
    RangeEncoder coder;
    auto corners = mesh.texcoord_triangles;
    code_texture_corners(coder, mesh.triangles, mesh.vertex_count(), VT, corners);
    std::vector<std::array<std::int32_t, 2>> values(VT);
    for (std::uint32_t i = 0; i < VT; ++i)
        for (int c = 0; c < 2; ++c)
            values[i][std::size_t(c)] = std::int32_t(std::lround(std::clamp(mesh.texcoords[i][c], -128.0f, 128.0f) / kTexcoordStep));
    VertexValueModel<2> model;
    code_values<2>(coder, model, traverse(VT, mesh.texcoord_triangles), values);
    write_coded(out, coder);
    return out.take();
}

Result<void> decode_texcoords(ByteView bytes, Mesh& mesh) {
    ByteReader in(bytes);
    const std::uint64_t VT = in.varint();
    const ByteView coded = in.bytes(in.varint());
    if (!in.ok() || !in.at_end()) return damaged("texture coordinate");
    if (VT > kMaxVertices || VT == 0) return Error{ErrorCode::limit_exceeded, "the texture coordinate blob announces no or too many coordinates"};
    RangeDecoder coder(coded);
    std::vector<Triangle> corners(mesh.triangles.size());
    code_texture_corners(coder, mesh.triangles, mesh.vertex_count(), std::uint32_t(VT), corners);
    if (coder.failed()) return damaged("texture coordinate");
    std::vector<std::array<std::int32_t, 2>> values(VT);
    VertexValueModel<2> model;
    code_values<2>(coder, model, traverse(std::uint32_t(VT), corners), values);
    if (!coder.complete()) return damaged("texture coordinate");
    mesh.texcoord_triangles = std::move(corners);
    mesh.texcoords.resize(VT);
    for (std::size_t i = 0; i < VT; ++i)
        mesh.texcoords[i] = {kTexcoordStep * float(values[i][0]), kTexcoordStep * float(values[i][1])};
    return {};
}

}  // namespace mien::coding
