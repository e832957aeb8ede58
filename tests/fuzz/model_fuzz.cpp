#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>

#include "coding/layer_code.hpp"
#include "coding/mesh_code.hpp"
#include "decoder/model_decoder.hpp"

// The first byte chooses the blob and the mesh size, the rest is the blob.
namespace {

using namespace mien;

std::vector<Triangle> small_mesh(std::uint32_t V) {
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i + 2 < V; ++i) triangles.push_back({i, i + 1, i + 2});
    return triangles;
}

void check(bool holds) {
    if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    if (size < 1) return 0;
    const std::uint32_t V = 3 + bytes[0] / 8;
    const ByteView blob(reinterpret_cast<const std::byte*>(bytes + 1), size - 1);
    Mesh mesh;
    mesh.triangles = small_mesh(V);
    switch (bytes[0] % 8) {
        case 0: {
            const auto mesh_of = coding::decode_connectivity(blob);
            if (mesh_of.ok())
                for (const Triangle& t : mesh_of->triangles) check(t[0] < mesh_of->V && t[1] < mesh_of->V && t[2] < mesh_of->V);
            break;
        }
        case 1:
            if (coding::decode_shape(blob, V, mesh).ok()) {
                check(mesh.positions.allFinite() && mesh.triangle_surfaces().size() == V - 2);
                for (std::uint32_t v = 0; v < mesh.mirror.size(); ++v) check(mesh.mirror.size() == V && mesh.mirror[mesh.mirror[v]] == v);
            }
            break;
        case 2:
            mesh.positions = Points::Zero(V, 3);
            if (coding::decode_texcoords(blob, mesh).ok())
                for (const Triangle& t : mesh.texcoord_triangles) check(t[0] < mesh.texcoords.size() && t[1] < mesh.texcoords.size() && t[2] < mesh.texcoords.size());
            break;
        case 3: {
            const auto blend = coding::decode_blend(blob, V);
            if (blend.ok())
                for (const auto& term : blend->rows.terms) check(term.column < blend->sites.size());
            break;
        }
        case 4: {
            const auto targets = coding::decode_blendshapes(blob, V, mesh.triangles);
            if (targets.ok())
                for (const auto& target : *targets) check(target.offsets.rows() == V && target.offsets.allFinite());
            break;
        }
        case 5: {
            const auto eyes = coding::decode_eyes(blob, V);
            if (eyes.ok())
                for (const auto& eye : *eyes)
                    if (eye)
                        for (const std::uint32_t v : eye->vertices) check(v < V);
            break;
        }
        case 6: {
            const auto lid = coding::decode_lid(blob, V);
            if (lid.ok())
                for (const auto& member : lid->members) check(member.vertex < V && member.share >= 0 && member.weight <= 1 && member.hold <= 1);
            const auto contact = coding::decode_contact(blob, V);
            if (!contact.ok()) break;
            for (const auto& pair : contact->pairs) check(pair[0] < V && pair[1] < V);
            for (const auto& member : contact->members) check(member.vertex < V && member.hold != 0 && std::abs(member.hold) <= 1);
            break;
        }
        default: {
            // The length of a manifest, the manifest, then its blobs: the first two bytes of a hash say where one lies.
            if (blob.empty()) break;
            const std::size_t cut = std::min<std::size_t>(1 + std::to_integer<std::size_t>(blob[0]), blob.size());
            const Bytes manifest(blob.begin() + 1, blob.begin() + long(cut));
            const ByteView rest = blob.subspan(cut);
            const Hash name = sha256(manifest);
            std::map<Hash, Bytes> blobs;
            const auto model = decoder::decode_model(name, [&](const Hash& hash) {
                if (hash == name) return &manifest;
                const std::size_t first = std::min<std::size_t>(hash.bytes[0], rest.size());
                const ByteView part = rest.subspan(first, std::min<std::size_t>(hash.bytes[1], rest.size() - first));
                return static_cast<const Bytes*>(&(blobs[hash] = Bytes(part.begin(), part.end())));
            });
            if (!model.ok()) break;
            model::LinearMotion still;
            const Eigen::Index points = model->point_count();
            if (points > 1000) break;
            Eigen::Index d = 3 * points;
            if (const auto* shapes = std::get_if<model::BlendshapeBase>(&model->base)) d = Eigen::Index(shapes->targets.size());
            if (const Points* markers = model::driving_markers(*model)) d = 3 * markers->rows();
            still.mean = Eigen::VectorXf::Zero(d);
            still.components = Eigen::MatrixXf::Zero(d, 0);
            check(model::evaluate(*model, model::compose(*model, still), {}).rows() == points);
        }
    }
    return 0;
}
