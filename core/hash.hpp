#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace mien {

using Bytes = std::vector<std::byte>;
using ByteView = std::span<const std::byte>;

/// SHA-256: the name of an immutable blob.
struct Hash {
    std::array<std::uint8_t, 32> bytes{};
    auto operator<=>(const Hash&) const = default;
    std::string hex() const;  ///< 64 lower-case digits
};

Hash sha256(ByteView bytes);

/// CRC-32C (Castagnoli, reflected polynomial 0x82F63B78), as iSCSI and ext4 use it.
std::uint32_t crc32c(ByteView bytes, std::uint32_t previous = 0);

}  // namespace mien
