#pragma once

#include <vector>

#include "core/clip.hpp"
#include "core/result.hpp"
#include "model/face_model.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

/// Where skin colour comes from: nowhere, the first picture of the clip's texture, or the stream's texture track.
enum class Albedo { none, picture, video };

struct ModelOptions {
    protocol::MotionKind kind = protocol::MotionKind::vertices;
    Albedo albedo = Albedo::picture;
    float step = 1.0f / 32;      ///< grid of the neutral positions, mm
};

struct EncodedModel {
    Hash manifest;
    std::vector<protocol::StaticBlob> blobs;   ///< manifest first, then in fetching order
    model::FaceModel model;                    ///< as a decoder will have it (quantised as stored)
};

/// Grid of the neutral mesh that suits an asked RMS error: the largest power of two, mm, that adds less than a tenth to
/// its square.
float shape_step(double rms_mm);

/// Makes the face model of a clip whose motion is sent as `options.kind` and packs it into blobs. Depends on the static
/// parts of the clip alone, so a second clip of one actor gives the same hashes; only where no mesh is known do the
/// markers' own mean places stand in for it.
Result<EncodedModel> encode_model(const Clip& clip, const ModelOptions& options);

}  // namespace mien::encoder
