#include "decoder/mesh_blobs.hpp"

#include "coding/mesh_code.hpp"

namespace mien::decoder {

Result<const Bytes*> needed_blob(const FindBlob& find, const Hash& hash) {
    const Bytes* bytes = find(hash);
    if (!bytes) return Error{ErrorCode::missing, "the face model lacks its blob " + hash.hex().substr(0, 12)};
    return bytes;
}

Result<const Bytes*> needed_blob(const FindBlob& find, const protocol::Layer& layer, std::size_t i) {
    if (i >= layer.blobs.size()) return Error{ErrorCode::damaged, "the model manifest names too few blobs for a layer"};
    return needed_blob(find, layer.blobs[i]);
}

Result<Mesh> mesh_of(const FindBlob& find, const protocol::Layer& layer) {
    MIEN_TRY(connectivity_bytes, needed_blob(find, layer, 0));
    MIEN_TRY(connectivity, coding::decode_connectivity(*connectivity_bytes));
    Mesh mesh;
    mesh.triangles = std::move(connectivity.triangles);
    MIEN_TRY(shape_bytes, needed_blob(find, layer, 1));
    MIEN_CHECK(coding::decode_shape(*shape_bytes, connectivity.V, mesh));
    if (layer.blobs.size() > 2) {
        MIEN_TRY(texcoord_bytes, needed_blob(find, layer, 2));
        MIEN_CHECK(coding::decode_texcoords(*texcoord_bytes, mesh));
    }
    return mesh;
}

}  // namespace mien::decoder
