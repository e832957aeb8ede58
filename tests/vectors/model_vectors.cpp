#include "model_vectors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>

#include "coding/coefficient_planes.hpp"
#include "coding/detail_code.hpp"
#include "coding/layer_code.hpp"
#include "decoder/mesh_blobs.hpp"
#include "encoder/detail_encoder.hpp"
#include "encoder/mesh_blobs.hpp"
#include "protocol/messages.hpp"
#include "tests/detail/small_model.hpp"
#include "tests/vectors/mirrored_sheet.hpp"
#include "tools/stored_stream.hpp"

namespace mien::vectors {
namespace {

using protocol::BlobKind;
using protocol::LayerKind;

Bytes file_of(const protocol::Manifest& manifest, encoder::BlobList& list) {
    const Bytes bytes = protocol::encode_manifest(manifest);
    const Hash hash = sha256(bytes);
    list.blobs().insert(list.blobs().begin(), {hash, BlobKind::manifest, bytes});
    return encoder::model_file(hash, list.blobs(), manifest.actor);
}

/// A face of blend coefficients over four markers, with target shapes, eyes and lips: every layer that has no detail.
Bytes make_face() {
    const Mesh mesh = mirrored_sheet(9, 17);
    encoder::BlobList list;
    protocol::Manifest manifest;
    manifest.actor = "sheet";
    auto stored = encoder::store_mesh(mesh, 1.0f / 32, true, list);
    manifest.layers.push_back({LayerKind::shape, stored->blobs});
    const auto add = [&](LayerKind layer, BlobKind kind, Bytes bytes) { manifest.layers.push_back({layer, {list.add(kind, std::move(bytes))}}); };
    coding::SparseRows rows{{0}, {}};
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        for (std::uint32_t m = v % 3; m < 4; m += 1 + v % 2) rows.terms.push_back({m, float(1 + (v + m) % 4) / 16});
        rows.row_start.push_back(std::uint32_t(rows.terms.size()));
    }
    add(LayerKind::blend, BlobKind::blend, coding::encode_blend({{{0, 1, 2}, {0.5f, 0.25f, 0.25f}}, {{8, 8, 8}, {1, 0, 0}}, {{20, 21, 30}, {0.1f, 0.2f, 0.7f}}, {{40, 40, 40}, {1, 0, 0}}}, rows));
    std::array<std::optional<coding::Ball>, 2> eyes;
    eyes[1] = coding::Ball{{3.5f, 20, -2.25f}, {0, 1, 2, 7, 9, 10}};
    add(LayerKind::eyes, BlobKind::eyes, coding::encode_eyes(eyes));
    add(LayerKind::contact, BlobKind::contact, coding::encode_contact({{{3, 12}, {5, 14}}, {{3, 1}, {4, 0.5f}, {12, -1}, {13, -0.25f}}}));
    add(LayerKind::lid, BlobKind::lid, coding::encode_lid({{3.5f, 20, -2.25f}, {{6, 1.5f, 1, 0.2f}, {7, 1, 0.6f, 1}, {30, 0.25f, 0.4f, 0}}}));
    return file_of(manifest, list);
}

/// Target shapes: a base shape of their own, which may not stand beside blend coefficients.
Bytes make_rig() {
    const Mesh mesh = mirrored_sheet(3, 5);
    encoder::BlobList list;
    protocol::Manifest manifest;
    manifest.actor = "rig";
    auto stored = encoder::store_mesh(mesh, 1.0f / 16, true, list);
    manifest.layers.push_back({LayerKind::shape, stored->blobs});
    std::vector<Blendshape> targets;
    for (int t = 0; t < 2; ++t) {
        Blendshape target{t == 0 ? "jaw" : "brow \xc3\xa9", Points::Zero(mesh.positions.rows(), 3)};
        for (Eigen::Index v = 0; v < target.offsets.rows(); ++v)
            if ((v + t) % 5 < 3) target.offsets.row(v) << 0.5f * std::sin(float(v)), -2.0f + 0.1f * float(v), 0.3f * float(t);
        targets.push_back(std::move(target));
    }
    manifest.layers.push_back({LayerKind::blendshapes, {list.add(BlobKind::blendshapes, coding::encode_blendshapes(targets, mesh.triangles, 0.03125f))}});
    return file_of(manifest, list);
}

/// Leaves out texels here and there, so that runs of all lengths are transformed.
void pierce(model::DomainMap& domain, const std::vector<model::PolynomialMap*>& maps) {
    model::DomainMap rest;
    rest.width = domain.width;
    rest.height = domain.height;
    std::vector<std::uint32_t> kept;
    for (const auto& run : domain.runs) {
        const auto begin = std::uint32_t(kept.size());
        for (std::uint32_t i = run.begin; i < run.end; ++i) {
            const std::uint32_t x = domain.place[i] % std::uint32_t(domain.width), y = domain.place[i] / std::uint32_t(domain.width);
            if ((x * x + 3 * y) % 11 < 3 && x > y) continue;
            kept.push_back(i);
            rest.place.push_back(domain.place[i]);
            rest.b1.push_back(domain.b1[i]);
            rest.b2.push_back(domain.b2[i]);
        }
        if (kept.size() > begin) rest.runs.push_back({run.triangle, begin, std::uint32_t(kept.size())});
    }
    for (model::PolynomialMap* map : maps) {
        model::PolynomialMap fewer(map->channels, map->order, kept.size());
        for (int c = 0; c < map->channels; ++c)
            for (int k = 0; k < model::term_count(map->order); ++k)
                for (std::size_t i = 0; i < kept.size(); ++i) fewer.plane(c, k)[i] = map->plane(c, k)[kept[i]];
        *map = std::move(fewer);
    }
    domain = std::move(rest);
}

/// A small detail model, driven by markers that are not those of its training.
Result<Bytes> make_detail() {
    SmallModel small(28, 44);
    pierce(small.model.medium_domain, {&small.model.medium});
    pierce(small.model.fine_domain, {&small.model.fine, &small.model.albedo});
    MIEN_TRY(coded, encoder::encode_detail(small.model, small.moments, "sheet", {.medium = 0.1, .fine = 0.01, .albedo = 0.01, .stages = 3, .mesh_step = 1.0f / 16}));
    MIEN_TRY(manifest, protocol::parse_manifest(coded.blobs[0].bytes));
    coding::DrivingMarkers markers;
    for (std::uint32_t m = 0; m < 5; ++m) markers.sites.push_back({{3 * m, 3 * m + 1, 3 * m + 9}, {0.5f, 0.125f * float(m), 0.5f - 0.125f * float(m)}});
    markers.rest_offsets.resize(5, 3);
    for (Eigen::Index i = 0; i < markers.rest_offsets.size(); ++i) markers.rest_offsets.data()[i] = 0.25f * float(i % 7) - 0.6f;
    const Bytes bytes = coding::encode_driving_markers(markers);
    for (auto& layer : manifest.layers)
        if (layer.kind == LayerKind::thin_shell) layer.blobs.push_back(sha256(bytes));
    coded.blobs.push_back({sha256(bytes), BlobKind::driving_markers, bytes});
    const Bytes text = protocol::encode_manifest(manifest);
    coded.blobs[0] = {sha256(text), BlobKind::manifest, text};
    return encoder::model_file(coded.blobs[0].hash, coded.blobs, "detail");
}

/// Numbers as they are hashed: little-endian, four bytes each (this project is built for little-endian machines).
class Numbers {
public:
    template <class T>
    void add(T value) {
        static_assert(sizeof(T) == 4);
        const auto* begin = reinterpret_cast<const std::byte*>(&value);
        bytes_.insert(bytes_.end(), begin, begin + 4);
    }
    void steps(double value, double per_unit) { add(std::int32_t(std::lround(value * per_unit))); }
    void add(const Points& points) {
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            for (int c = 0; c < 3; ++c) add(points(i, c));
    }
    void add(const std::vector<Triangle>& triangles) {
        for (const Triangle& t : triangles)
            for (const std::uint32_t v : t) add(v);
    }
    void add(const std::vector<std::uint32_t>& numbers) {
        for (const std::uint32_t n : numbers) add(n);
    }
    void add_sites(const std::vector<Site>& sites) {
        for (const Site& site : sites)
            for (int k = 0; k < 3; ++k) add(site.vertices[k]), steps(double(site.weights[k]), 4096);
    }
    std::string hex() const { return sha256(bytes_).hex(); }

private:
    Bytes bytes_;
};

}  // namespace

const std::vector<ModelVector>& model_vectors() {
    static const std::vector<ModelVector> all{
        {"model_face.mien", "a mirrored mesh in parts, with seams; blend coefficients, one eye, lips, a lid"},
        {"model_rig.mien", "a mirrored mesh and two target shapes"},
        {"model_detail.mien", "shell, driving markers, marker domain, masks with holes, three maps of three stages"},
    };
    return all;
}

Result<Bytes> make_model_vector(const ModelVector& vector) {
    if (vector.file == "model_face.mien") return make_face();
    if (vector.file == "model_rig.mien") return make_rig();
    return make_detail();
}

Result<std::vector<std::string>> model_digests(const Bytes& file) {
    MIEN_TRY(stream, tools::StoredStream::from_bytes(std::make_shared<Bytes>(file)));
    const decoder::FindBlob find = [&](const Hash& hash) { return stream.blob(hash); };
    MIEN_TRY(bytes, decoder::needed_blob(find, stream.header().model));
    MIEN_TRY(manifest, protocol::parse_manifest(*bytes));
    std::vector<std::string> lines;
    Mesh mesh;
    std::uint32_t markers = 0;
    for (const protocol::Layer& layer : manifest.layers) {
        Numbers numbers;
        const auto blob = [&](std::size_t i) { return decoder::needed_blob(find, layer, i); };
        const auto done = [&](const std::string& part = "") { lines.push_back(fmt::format("{}{} {}", int(layer.kind), part, numbers.hex())); };
        switch (layer.kind) {
            case LayerKind::shape: {
                MIEN_TRY(stored, decoder::mesh_of(find, layer));
                mesh = std::move(stored);
                numbers.add(mesh.positions);
                numbers.add(mesh.triangles);
                numbers.add(mesh.mirror);
                for (const MeshPart& part : mesh.parts) numbers.add(std::uint32_t(part.surface)), numbers.add(part.first), numbers.add(part.count);
                for (const Vec2& place : mesh.texcoords) numbers.add(place.x()), numbers.add(place.y());
                numbers.add(mesh.texcoord_triangles);
                break;
            }
            case LayerKind::blend: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(blend, coding::decode_blend(*content, mesh.vertex_count()));
                for (const Site& site : blend.sites)
                    for (int k = 0; k < 3; ++k) numbers.add(site.vertices[k]), numbers.add(site.weights[k]);
                for (std::size_t v = 0; v + 1 < blend.rows.row_start.size(); ++v) {
                    numbers.add(blend.rows.row_start[v + 1] - blend.rows.row_start[v]);
                    for (std::size_t i = blend.rows.row_start[v]; i < blend.rows.row_start[v + 1]; ++i)
                        numbers.add(blend.rows.terms[i].column), numbers.steps(double(blend.rows.terms[i].share), 255);
                }
                break;
            }
            case LayerKind::blendshapes: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(targets, coding::decode_blendshapes(*content, mesh.vertex_count(), mesh.triangles));
                for (const Blendshape& target : targets) numbers.add(target.offsets);
                break;
            }
            case LayerKind::eyes: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(eyes, coding::decode_eyes(*content, mesh.vertex_count()));
                for (const auto& eye : eyes) {
                    numbers.add(std::uint32_t(eye.has_value()));
                    if (!eye) continue;
                    for (int c = 0; c < 3; ++c) numbers.add(eye->centre[c]);
                    numbers.add(eye->vertices);
                }
                break;
            }
            case LayerKind::contact: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(contact, coding::decode_contact(*content, mesh.vertex_count()));
                for (const auto& pair : contact.pairs) numbers.add(pair[0]), numbers.add(pair[1]);
                for (const auto& member : contact.members) numbers.add(member.vertex), numbers.steps(double(member.hold), 127);
                break;
            }
            case LayerKind::lid: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(lid, coding::decode_lid(*content, mesh.vertex_count()));
                for (int c = 0; c < 3; ++c) numbers.add(lid.centre[c]);
                for (const auto& member : lid.members) numbers.add(member.vertex), numbers.steps(double(member.share), 64), numbers.steps(double(member.weight), 255), numbers.steps(double(member.hold), 255);
                break;
            }
            case LayerKind::thin_shell: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(shell, coding::decode_shell(*content, mesh.vertex_count()));
                markers = std::uint32_t(shell.sites.size());
                numbers.add_sites(shell.sites);
                numbers.add(shell.fixed);
                if (layer.blobs.size() > 1) {
                    MIEN_TRY(more, blob(1));
                    MIEN_TRY(driving, coding::decode_driving_markers(*more, mesh.vertex_count()));
                    numbers.add_sites(driving.sites);
                    for (Eigen::Index i = 0; i < driving.rest_offsets.rows(); ++i)
                        for (int c = 0; c < 3; ++c) numbers.steps(double(driving.rest_offsets(i, c)), 64);
                }
                break;
            }
            case LayerKind::marker_domain: {
                MIEN_TRY(content, blob(0));
                MIEN_TRY(domain, coding::decode_marker_domain(*content, markers));
                numbers.add(domain.reach);
                numbers.add(domain.triangles);
                for (const auto& axes : domain.axes)
                    for (const float number : axes) numbers.add(number);
                for (const float extent : domain.extents) numbers.add(extent);
                for (const float number : domain.factors) numbers.steps(double(number), 64);
                break;
            }
            case LayerKind::medium:
            case LayerKind::fine:
            case LayerKind::albedo_map: {
                MIEN_TRY(mask_bytes, blob(0));
                MIEN_TRY(mask, coding::decode_mask(*mask_bytes));
                for (const std::uint8_t set : mask.set) numbers.add(std::uint32_t(set));
                done(" mask");
                const coding::MaskedWavelet wavelet(mask);
                MIEN_TRY(map_bytes, blob(1));
                MIEN_TRY(map, coding::decode_map(*map_bytes));
                coding::CoefficientPlanes planes(wavelet, map.head.channels * model::term_count(model::PolynomialOrder(map.head.order)));
                for (int stage = 0; stage + 1 < int(layer.blobs.size()); ++stage) {
                    coding::MapStage next = map.first;
                    if (stage > 0) {
                        MIEN_TRY(content, blob(std::size_t(stage) + 1));
                        MIEN_TRY(refinement, coding::decode_refinement(*content, stage));
                        next = std::move(refinement);
                    }
                    if (!planes.decode(next.coded)) return Error{ErrorCode::damaged, "a stage of a map"};
                    numbers = {};
                    for (const std::int8_t lift : next.lift) numbers.add(std::int32_t(lift));
                    for (int p = 0; p < planes.planes(); ++p)
                        for (std::uint32_t i = 0; i < wavelet.size(); ++i) numbers.add(planes.plane(p)[i]);
                    done(fmt::format(" stage {}", stage));
                }
                continue;
            }
            default: return Error{ErrorCode::invalid, "no vector has such a layer"};
        }
        done();
    }
    return lines;
}

}  // namespace mien::vectors
