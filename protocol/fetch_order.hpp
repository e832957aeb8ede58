#pragma once

#include "protocol/stream.hpp"

namespace mien::protocol {

/// The static blobs of a stream in the order in which a player fetches them.
struct FetchOrder {
    std::vector<BlobInfo> blobs;
    std::size_t needed = 0;   ///< so many, from the first on, nothing plays without; the rest are refinements of what they give

    /// How many blobs, from the first on, a player begins with that spends `bytes` (unpacked) on them: those that are needed, and what fits beside them.
    std::size_t within(std::uint64_t bytes) const;
};

/// Manifest, mesh, motion bases, first stages of detail maps and whatever else is no refinement come first, then the refinements, each part as the
/// catalogue has it: by that the encoder says which of them is worth most.
FetchOrder fetch_order(const Catalogue& catalogue);

/// Sum of the blobs' unpacked bytes.
std::uint64_t total_bytes(const Catalogue& catalogue);

}  // namespace mien::protocol
