#pragma once

#include "decoder/model_decoder.hpp"
#include "model/detail_model.hpp"

namespace mien::decoder {

/// Builds the detail model that manifest blob `manifest` names. Mesh, shell and marker domain must be there; of a map, the mask and the
/// first stage, or the layer stays empty; refinements count up to the first that `find` does not have. So a model may be shown
/// long before all of it has come, and is decoded again when more has. Errors: `missing`, `damaged`, `limit_exceeded` (of the map or
/// marker domain, before it is allocated); a manifest without these layers is `invalid`.
Result<model::DetailModel> decode_detail(const Hash& manifest, const FindBlob& find);

/// The model of a stored stream, as a model file is one.
Result<model::DetailModel> decode_detail_file(ByteView file);

}  // namespace mien::decoder
