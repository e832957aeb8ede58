#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "tools/stored_stream.hpp"

namespace mien::tools {

/// The bytes of a file by what they are for. They add up to the total; what a lost message left unclaimed counts as framing.
struct ByteSplit {
    std::uint64_t total = 0, shape = 0, detail = 0, connectivity = 0, basis = 0, probabilities = 0, coefficients = 0, pose = 0, texture = 0,
                  sound = 0, framing = 0;

    /// All that moves the points: detail, framing, connectivity, texture coordinates, texture and sound apart.
    std::uint64_t motion() const { return shape + basis + probabilities + coefficients + pose; }
};

/// Decodes the motion track once, to tell pose from coefficients.
Result<ByteSplit> split_bytes(const StoredStream& stream);

/// The bytes of one layer of a face model.
struct LayerBytes {
    std::string name;
    std::size_t blobs = 0;
    std::uint64_t bytes = 0;
};
/// Those of a model file, layer by layer; a blob of several layers counts with the first. The last entry is the framing: manifest, hashes and
/// lengths. They add up to the file.
Result<std::vector<LayerBytes>> split_model(const StoredStream& stream);

}  // namespace mien::tools
