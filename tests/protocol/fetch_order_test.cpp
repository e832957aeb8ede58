#include "protocol/fetch_order.hpp"

#include <gtest/gtest.h>

namespace mien::protocol {
namespace {

/// A detail model as an encoder lists it, the motion basis behind it; sizes in bytes.
Catalogue driven_stream() {
    Catalogue catalogue;
    const auto add = [&](BlobKind kind, std::uint64_t size) {
        Hash hash;
        hash.bytes[0] = std::uint8_t(catalogue.blobs.size() + 1);
        catalogue.blobs.push_back({hash, kind, size});
    };
    for (const BlobKind kind : {BlobKind::manifest, BlobKind::connectivity, BlobKind::shape, BlobKind::texcoords, BlobKind::shell, BlobKind::marker_domain})
        add(kind, 10);
    for (const BlobKind kind : {BlobKind::texel_mask, BlobKind::detail_map, BlobKind::detail_map}) add(kind, 20);
    for (const std::uint64_t size : {30, 40, 50}) add(BlobKind::refinement, size);
    add(BlobKind::motion_basis, 5);
    return catalogue;
}

TEST(FetchOrder, WhatNothingPlaysWithoutComesFirst) {
    const Catalogue catalogue = driven_stream();
    const FetchOrder order = fetch_order(catalogue);
    ASSERT_EQ(order.blobs.size(), catalogue.blobs.size());
    EXPECT_EQ(order.needed, 10u);
    for (std::size_t b = 0; b < order.blobs.size(); ++b) EXPECT_EQ(order.blobs[b].kind == BlobKind::refinement, b >= order.needed) << b;
    EXPECT_EQ(order.blobs.front().kind, BlobKind::manifest);
    EXPECT_EQ(order.blobs[order.needed - 1].kind, BlobKind::motion_basis) << "the basis stands last in the catalogue, and playing needs it";
    for (std::size_t b = order.needed; b < order.blobs.size(); ++b)
        EXPECT_EQ(order.blobs[b].hash, catalogue.blobs[b - 1].hash) << "refinements as the catalogue has them";
}

TEST(FetchOrder, ABudgetTakesWholeBlobsAndNeverLessThanIsNeeded) {
    const FetchOrder order = fetch_order(driven_stream());   // 125 bytes are needed
    EXPECT_EQ(order.within(0), order.needed);
    EXPECT_EQ(order.within(125), order.needed);
    EXPECT_EQ(order.within(154), order.needed);
    EXPECT_EQ(order.within(155), order.needed + 1);
    EXPECT_EQ(order.within(244), order.needed + 2);
    EXPECT_EQ(order.within(245), order.blobs.size());
    EXPECT_EQ(order.within(~std::uint64_t(0)), order.blobs.size());
    EXPECT_EQ(total_bytes(driven_stream()), 245u);
}

TEST(FetchOrder, AStreamWithoutRefinementsNeedsAllItHas) {
    Catalogue catalogue = driven_stream();
    std::erase_if(catalogue.blobs, [](const BlobInfo& blob) { return blob.kind == BlobKind::refinement; });
    const FetchOrder order = fetch_order(catalogue);
    EXPECT_EQ(order.needed, catalogue.blobs.size());
    EXPECT_EQ(order.within(0), catalogue.blobs.size());
    EXPECT_EQ(fetch_order({}).within(0), 0u);
}

}  // namespace
}  // namespace mien::protocol
