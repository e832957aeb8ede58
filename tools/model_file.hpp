#pragma once

#include <string>

#include "encoder/model_encoder.hpp"

namespace mien::tools {

/// The model of a file that `mien train` or `mien remap` wrote, with its blobs as they are. Errors name the file.
Result<encoder::EncodedModel> read_model(const std::string& path);

}  // namespace mien::tools
