#pragma once

#include <functional>
#include <memory>

#include "core/result.hpp"
#include "model/face_model.hpp"
#include "protocol/stream.hpp"

namespace mien::decoder {

/// Finds an unpacked static blob by its hash; null when it is not there.
using FindBlob = std::function<const Bytes*(const Hash& hash)>;

class DetailDecoder;

/// Builds the face model that manifest blob `manifest` names from its blobs. Static textures stay encoded: they come back
/// as `static_albedo` only through decoder_av's decode_picture. Maps of its detail have the stages that `find` has by now; `growing`, when it is given, gets what
/// takes those that come later, and null when none is missing.
Result<model::FaceModel> decode_model(const Hash& manifest, const FindBlob& find, std::unique_ptr<DetailDecoder>* growing = nullptr);

/// Whether motion of this kind and count drives this model. Where it does not, the stream is damaged.
bool fits(const model::FaceModel& model, const protocol::MotionInfo& info);

}  // namespace mien::decoder
