#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh.hpp"

namespace mien::coding {

/// In which order the points of a motion basis are coded, and from which earlier points each is predicted.
struct PointOrder {
    struct Reference {
        std::uint32_t point;
        std::int32_t weight;
    };
    static constexpr int kLevels = 8;

    std::vector<std::uint32_t> order;         ///< N, a permutation of the points
    std::vector<std::uint8_t> level;          ///< N, by position in `order`: kLevels - 1 the coarsest .. 0
    std::vector<std::uint32_t> first;         ///< N + 1, by position: its references are first[i] .. first[i + 1]
    std::vector<Reference> references;
    std::vector<std::uint32_t> partner;       ///< N, by position: the point that mirrors it when that is coded before, else itself

    std::span<const Reference> of(std::size_t position) const {
        return {references.data() + first[position], references.data() + first[position + 1]};
    }
};

/// Points as they come, none predicted.
PointOrder plain_order(std::uint32_t points);

/// Coarse to fine over a mesh: level l holds points at least 2^l edges apart, found greedily in index order; a point is
/// predicted from the nearest points coded before it, by distance in edges. Integers and connectivity only, so both
/// sides agree. Triangles that name points >= `points` are left out.
PointOrder mesh_order(std::uint32_t points, std::span<const Triangle> triangles, std::span<const std::uint32_t> mirror = {});

/// Each point i > 0 is predicted from the listed earlier points (parents[i] < i; i itself: none).
PointOrder parent_order(std::span<const std::uint32_t> parents);

}  // namespace mien::coding
