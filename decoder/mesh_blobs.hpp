#pragma once

#include "decoder/model_decoder.hpp"

namespace mien::decoder {

/// A blob that a model cannot do without: `missing` when it is not there.
Result<const Bytes*> needed_blob(const FindBlob& find, const Hash& hash);
Result<const Bytes*> needed_blob(const FindBlob& find, const protocol::Layer& layer, std::size_t i);

/// The mesh of a shape or points layer.
Result<Mesh> mesh_of(const FindBlob& find, const protocol::Layer& layer);

}  // namespace mien::decoder
