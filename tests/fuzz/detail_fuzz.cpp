#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>

#include "coding/coefficient_planes.hpp"
#include "coding/detail_code.hpp"
#include "coding/mesh_code.hpp"
#include "decoder/detail_decoder.hpp"
#include "protocol/messages.hpp"

// The first byte chooses a blob by itself, or a whole model over a small sheet whose other blobs are the input's parts: a length of
// two bytes each.
namespace {

using namespace mien;

void check(bool holds) {
    if (!holds) std::abort();
}

Mesh sheet(std::uint32_t side) {
    Mesh mesh;
    mesh.positions.resize(side * side, 3);
    for (std::uint32_t i = 0; i < side * side; ++i) {
        mesh.positions.row(i) << float(i % side) * 4, float(i / side) * 4, 0;
        mesh.texcoords.emplace_back(float(i % side) / float(side - 1), float(i / side) / float(side - 1));
    }
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            mesh.triangles.push_back({a, a + 1, a + side + 1});
            mesh.triangles.push_back({a, a + side + 1, a + side});
        }
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

void whole_model(ByteView rest) {
    static const Mesh mesh = sheet(5);
    static const Bytes base[3] = {coding::encode_connectivity(25, mesh.triangles), coding::encode_shape(mesh, 0.125f), coding::encode_texcoords(mesh)};
    std::map<Hash, Bytes> blobs;
    const auto add = [&](const Bytes& bytes) {
        const Hash hash = sha256(bytes);
        blobs[hash] = bytes;
        return hash;
    };
    const auto next = [&] {
        std::size_t size = 0;
        for (int i = 0; i < 2 && !rest.empty(); ++i, rest = rest.subspan(1)) size = size << 8 | std::to_integer<std::size_t>(rest[0]);
        const ByteView part = rest.first(std::min(size, rest.size()));
        rest = rest.subspan(part.size());
        return add(Bytes(part.begin(), part.end()));
    };
    using protocol::LayerKind;
    protocol::Manifest manifest;
    manifest.layers.push_back({LayerKind::shape, {add(base[0]), add(base[1]), add(base[2])}});
    manifest.layers.push_back({LayerKind::thin_shell, {next()}});
    manifest.layers.push_back({LayerKind::marker_domain, {next()}});
    const Hash mask = next();
    for (const auto kind : {LayerKind::medium, LayerKind::fine, LayerKind::albedo_map}) {
        protocol::Layer layer{kind, {mask}};
        layer.blobs.push_back(next());
        layer.blobs.push_back(next());
        manifest.layers.push_back(std::move(layer));
    }
    const Hash name = add(protocol::encode_manifest(manifest));
    const auto model = decoder::decode_detail(name, [&](const Hash& hash) -> const Bytes* {
        const auto found = blobs.find(hash);
        return found == blobs.end() || found->second.empty() ? nullptr : &found->second;
    });
    if (!model.ok()) return;
    for (const model::PolynomialMap* map : {&model->medium, &model->fine, &model->albedo})
        for (const float c : map->planes) check(std::isfinite(c));
    check(model->medium.texels == model->medium_domain.size() && (model->fine.texels == 0 || model->fine.texels == model->fine_domain.size()));
    const model::MarkerDriver driver(model->neutral, model->sites, model->fixed, model->marker_triangles);
    check(driver.response().allFinite());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    if (size < 1) return 0;
    const ByteView blob(reinterpret_cast<const std::byte*>(bytes + 1), size - 1);
    switch (bytes[0] % 6) {
        case 0: {
            const auto shell = coding::decode_shell(blob, 100);
            if (!shell.ok()) break;
            for (const Site& site : shell->sites)
                for (int i = 0; i < 3; ++i) check(site.vertices[i] < 100 && std::isfinite(site.weights[i]));
            for (const std::uint32_t v : shell->fixed) check(v < 100);
            break;
        }
        case 1: {
            const auto domain = coding::decode_marker_domain(blob, 3 + bytes[0] / 6);
            if (!domain.ok()) break;
            for (const float f : domain->factors) check(std::isfinite(f));
            for (const auto& row : domain->axes)
                for (const float a : row) check(std::isfinite(a));
            break;
        }
        case 2: {
            const auto mask = coding::decode_mask(blob);
            if (mask.ok()) check(mask->set.size() == std::size_t(mask->width) * std::size_t(mask->height));
            break;
        }
        case 3: {
            coding::TexelMask mask{9, 12, std::vector<std::uint8_t>(108, 1)};
            for (std::size_t i = 0; i < 108; i += 1 + bytes[0] / 6) mask.set[i] = 0;
            const coding::MaskedWavelet wavelet(mask);
            coding::CoefficientPlanes planes(wavelet, 3);
            const std::size_t half = blob.size() / 2;
            planes.decode(blob.first(half));
            planes.decode(blob.subspan(half));
            for (int p = 0; p < 3; ++p)
                for (std::uint32_t i = 0; i < wavelet.size(); ++i) check(std::abs(planes.plane(p)[i]) <= coding::CoefficientPlanes::kMaxValue);
            break;
        }
        case 4: {
            const auto markers = coding::decode_driving_markers(blob, 100);
            if (!markers.ok()) break;
            check(markers->rest_offsets.allFinite());
            for (const Site& site : markers->sites)
                for (int i = 0; i < 3; ++i) check(site.vertices[i] < 100 && std::isfinite(site.weights[i]));
            break;
        }
        default: whole_model(blob);
    }
    return 0;
}
