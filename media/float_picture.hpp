#pragma once

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::media {

/// How an OpenEXR file holds its numbers.
enum class ExrNumbers {
    float32,  ///< bit for bit, not compressed: noise in the low bits would not shrink, and large maps are read at the disk's rate
    half,     ///< 11 bits, deflated: for colours
};

/// An OpenEXR picture in memory: the planes R, G, B as 3 channels, or one grey plane as 1; alpha is dropped. Values are
/// linear; NaN and infinity stay. Sides up to 8192. Errors: damaged, limit_exceeded, unsupported_version (other planes).
Result<FloatMap> decode_exr(ByteView bytes);

/// OpenEXR bytes of a map of 1 or 3 channels.
Result<Bytes> encode_exr(const FloatMap& map, ExrNumbers numbers);

}  // namespace mien::media
