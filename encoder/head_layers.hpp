#pragma once

#include <vector>

#include "core/image.hpp"
#include "core/result.hpp"
#include "encoder/mesh_blobs.hpp"
#include "model/face_model.hpp"

namespace mien::encoder {

/// A model while it is packed: every function below adds a layer to all three, the model as decoders will have it.
struct ModelParts {
    protocol::Manifest manifest;
    BlobList list;
    model::FaceModel model;     ///< its neutral mesh is there first

    void layer(protocol::LayerKind kind, std::vector<Hash> blobs) { manifest.layers.push_back({kind, std::move(blobs)}); }
};

/// The vertices of the eyeballs of a mesh, the actor's right and left, ascending. Tear film and the like stay with the lids.
std::array<std::vector<std::uint32_t>, 2> eye_vertices(const Mesh& mesh);
/// Eyeballs that gaze turns; nothing for a mesh without.
void add_eyes(ModelParts& parts);
/// Upper lids of the neutral mesh as the clip has it, over the base shape that is there and that markers move.
Result<void> add_lids(const Mesh& neutral, ModelParts& parts);
/// Lips and lids of the neutral mesh as the clip has it, held apart where the base shape does not.
Result<void> add_contacts(const Mesh& neutral, ModelParts& parts);
/// Base shape by blend coefficients. With `beside_shell`, rows of skin are left out: a thin shell forms those.
Result<void> add_blend(const Mesh& neutral, const std::vector<Site>& sites, const std::vector<std::uint32_t>& rigid, bool beside_shell, ModelParts& parts);
/// A picture for all that no other layer colours.
Result<void> add_picture(const Image& picture, ModelParts& parts);

}  // namespace mien::encoder
