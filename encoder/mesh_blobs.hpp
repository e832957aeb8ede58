#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// Static blobs of one model, each once.
class BlobList {
public:
    Hash add(protocol::BlobKind kind, Bytes bytes);
    const Bytes& bytes_of(const Hash& hash) const;
    std::vector<protocol::StaticBlob>& blobs() { return blobs_; }

private:
    std::vector<protocol::StaticBlob> blobs_;
};

/// A mesh as decoders will have it, and the blobs it comes from: connectivity, shape and, where it has some, texture coordinates.
struct StoredMesh {
    Mesh mesh;
    std::vector<Hash> blobs;
};
/// Packs a neutral mesh on a grid of `step` mm, from side to side where that is shorter. Errors: it lies too far from the origin.
Result<StoredMesh> store_mesh(Mesh mesh, float step, bool mirrored, BlobList& blobs);

/// The mesh that decoders will have of `mesh`; storing it in turn changes nothing more. Errors: as store_mesh.
Result<Mesh> mesh_as_stored(const Mesh& mesh, float step);

}  // namespace mien::encoder
