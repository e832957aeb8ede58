#pragma once

#include <functional>
#include <vector>

#include "protocol/messages.hpp"

/// Finds the groups of a file that has no usable index. Internal to this room.
namespace mien::protocol {

struct ScanResult {
    std::vector<IndexEntry> entries;   ///< in file order
    std::uint64_t cut = 0;             ///< offset of a group that the file's end cuts; 0: none. It is the last entry
};

/// Exactly `size` bytes from `offset`, or why not.
using ReadExactly = std::function<Result<Bytes>(std::uint64_t offset, std::uint64_t size)>;

/// Walks from message to message between `begin` and `end`. Where one is damaged, goes on at the next group whose
/// checksum is sound. `known` tells which slots the header names.
ScanResult scan_groups(const ReadExactly& read, std::uint64_t begin, std::uint64_t end,
                       const std::function<bool(std::uint8_t slot)>& known);

}  // namespace mien::protocol
