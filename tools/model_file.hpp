#pragma once

#include <string>

#include "encoder/model_encoder.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {

/// The model of a file that `mien train` or `mien remap` wrote, with its blobs as they are. Errors name the file.
Result<encoder::EncodedModel> read_model(const std::string& path);
/// A model with the blobs that its manifest names, out of a stream or model file.
Result<encoder::EncodedModel> model_of(const StoredStream& stream);

}  // namespace mien::tools
