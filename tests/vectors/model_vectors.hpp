#pragma once

#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/result.hpp"

namespace mien::vectors {

/// Model files (stored streams without tracks) as an encoder made them once; model_digests.txt holds what a decoder makes of them.
struct ModelVector {
    std::string file;
    std::string shows;   ///< one line for README.md
};
const std::vector<ModelVector>& model_vectors();

/// Encodes `vector` anew. For a change of the format on purpose.
Result<Bytes> make_model_vector(const ModelVector& vector);

/// What a decoder makes of every layer of a model file: a line each, and of a map one for each of its stages. docs/format-model.md says
/// what is hashed.
Result<std::vector<std::string>> model_digests(const Bytes& file);

}  // namespace mien::vectors
