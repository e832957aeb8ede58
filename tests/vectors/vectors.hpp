#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"
#include "sample_stream.hpp"

/// The conformance vectors: small streams, good and bad, that pin the format. Files of these names lie beside this one;
/// the test makes them again and compares every byte, but for what zstd has a say in.
namespace mien::vectors {

struct Vector {
    std::string file;
    Bytes bytes;
    std::string shows;                        ///< one line for README.md
    bool made_again = true;                   ///< the file must be `bytes`; else it must only read as they do
    // What a reader must make of it.
    std::optional<ErrorCode> refused = {};    ///< why it does not open; none: it opens
    bool complete = true;                     ///< index and trailer are used as they are
    std::size_t objects = 0;                  ///< that can be read from it
    std::size_t lost_groups = 0;              ///< that the index names but whose checksum fails
    std::optional<protocol::sample::Stream> stream = {};   ///< whose every blob and object it must give back
};

std::vector<Vector> make_vectors();

}  // namespace mien::vectors
