#pragma once

#include "encoder/model_encoder.hpp"
#include "encoder/training_take.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {

/// A stream that others take their motion basis from, with the face model that it goes with.
struct StoredTake {
    encoder::TrainingTake take;
    encoder::EncodedModel model;      ///< with the blobs it names
    Points reference;                 ///< what offsets count from, N x 3 mm; empty for weights
    protocol::StreamHeader header;
};

/// Reads and decodes the motion of a stream file. Errors name the file: no motion, vertex motion, another scheme than mien's own.
Result<StoredTake> read_take(const std::string& path);

/// Refuses a model whose markers do not stand where the take's do.
Result<void> same_reference(const StoredTake& take, const model::FaceModel& model, const std::string& path);

}  // namespace mien::tools
