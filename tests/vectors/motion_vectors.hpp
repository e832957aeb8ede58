#pragma once

#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/result.hpp"

namespace mien::vectors {

/// Streams of motion alone, as an encoder made them once. Encoders may choose differently from build to build; what a decoder makes of
/// these bytes may not: motion_digests.txt holds it.
struct MotionVector {
    std::string file;
    std::string shows;   ///< one line for README.md
};
const std::vector<MotionVector>& motion_vectors();

/// Encodes `vector` anew. For a change of the format on purpose.
Result<Bytes> make_motion_vector(const MotionVector& vector);

/// SHA-256, in hexadecimal, of what a decoder makes of the motion of a stream file as long as it is the same on every machine: coder
/// states, coefficients and corrections (an integer times a step), presence.
Result<std::string> motion_digest(Bytes file);

}  // namespace mien::vectors
