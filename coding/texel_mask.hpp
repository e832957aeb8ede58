#pragma once

#include <cstdint>
#include <vector>

#include "core/byte_io.hpp"
#include "core/result.hpp"

namespace mien::coding {

/// Which texels of a map count, rows from the top, 0 or 1 each.
struct TexelMask {
    int width = 0, height = 0;
    std::vector<std::uint8_t> set;  ///< width * height
};

inline constexpr int kMaxMaskSide = 4096;  // texels: face scanners resolve 0.1 mm at most

/// A bitmap in a range coder with contexts of the ten nearest known texels (as JBIG has it). docs/format-detail.md gives the bytes.
Bytes encode_mask(const TexelMask& mask);
Result<TexelMask> decode_mask(ByteView bytes);

}  // namespace mien::coding
