#pragma once

#include <vector>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "model/face_model.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

struct EncodedModel {
    Hash manifest;
    std::vector<protocol::StaticBlob> blobs;   ///< manifest first, then in fetching order
    model::FaceModel model;                    ///< as a decoder will have it (quantised as stored)
};

/// Makes the face model of a clip whose motion is sent as `kind` and packs it into blobs. Depends only on the static
/// parts of the clip, so a second clip of one actor gives the same hashes. `video`: the stream has a texture track;
/// otherwise a static texture of the clip becomes part of the model.
Result<EncodedModel> encode_model(const Clip& clip, protocol::MotionKind kind, bool video);

}  // namespace mien::encoder
