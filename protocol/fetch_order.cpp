#include "protocol/fetch_order.hpp"

#include <algorithm>

namespace mien::protocol {

std::size_t FetchOrder::within(std::uint64_t bytes) const {
    std::uint64_t sum = 0;   // 4096 blobs of 256 MiB do not overflow it
    for (std::size_t b = 0; b < blobs.size(); ++b)
        if ((sum += blobs[b].size) > bytes && b >= needed) return b;
    return blobs.size();
}

FetchOrder fetch_order(const Catalogue& catalogue) {
    FetchOrder order{catalogue.blobs, 0};
    // Not the one of std::ranges: clang 14 does not compile it.
    const auto refinements = std::stable_partition(order.blobs.begin(), order.blobs.end(),
                                                   [](const BlobInfo& blob) { return blob.kind != BlobKind::refinement; });
    order.needed = std::size_t(refinements - order.blobs.begin());
    return order;
}

std::uint64_t total_bytes(const Catalogue& catalogue) {
    std::uint64_t sum = 0;
    for (const BlobInfo& blob : catalogue.blobs) sum += blob.size;
    return sum;
}

}  // namespace mien::protocol
