#include "encoder/mesh_blobs.hpp"

#include <algorithm>

#include "coding/mesh_code.hpp"
#include "encoder/mesh_mirror.hpp"

namespace mien::encoder {

using protocol::BlobKind;

Hash BlobList::add(BlobKind kind, Bytes bytes) {
    const Hash hash = sha256(bytes);
    for (const protocol::StaticBlob& known : blobs_)
        if (known.hash == hash) return hash;
    blobs_.push_back({hash, kind, std::move(bytes)});
    return hash;
}

const Bytes& BlobList::bytes_of(const Hash& hash) const {
    return std::find_if(blobs_.begin(), blobs_.end(), [&](const auto& blob) { return blob.hash == hash; })->bytes;
}

Result<StoredMesh> store_mesh(Mesh mesh, float step, bool mirrored, BlobList& blobs) {
    if (mesh.positions.size() > 0 && !(mesh.positions.cwiseAbs().maxCoeff() < step * coding::kMaxSteps))
        return Error{ErrorCode::invalid, "the neutral face lies too far from the origin for so small an error"};
    Bytes shape = coding::encode_shape(mesh, step);
    if (mirrored) mesh.mirror = find_mirror(mesh);
    if (mirrored && !mesh.mirror.empty()) {
        Bytes both = coding::encode_shape(mesh, step);
        if (both.size() < shape.size()) shape = std::move(both);
    }
    StoredMesh stored;
    stored.blobs = {blobs.add(BlobKind::connectivity, coding::encode_connectivity(mesh.vertex_count(), mesh.triangles)), blobs.add(BlobKind::shape, std::move(shape))};
    if (mesh.has_texcoords()) stored.blobs.push_back(blobs.add(BlobKind::texcoords, coding::encode_texcoords(mesh)));
    MIEN_TRY(connectivity, coding::decode_connectivity(blobs.bytes_of(stored.blobs[0])));
    stored.mesh.triangles = std::move(connectivity.triangles);
    MIEN_CHECK(coding::decode_shape(blobs.bytes_of(stored.blobs[1]), connectivity.V, stored.mesh));
    if (stored.blobs.size() > 2) MIEN_CHECK(coding::decode_texcoords(blobs.bytes_of(stored.blobs[2]), stored.mesh));
    return stored;
}

Result<Mesh> mesh_as_stored(const Mesh& mesh, float step) {
    BlobList blobs;
    MIEN_TRY(stored, store_mesh(mesh, step, true, blobs));
    return std::move(stored.mesh);
}

}  // namespace mien::encoder
