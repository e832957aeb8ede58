#pragma once

#include <limits>
#include <utility>
#include <vector>

#include "core/mesh.hpp"

namespace mien {

/// Distances along the skin: shortest paths over a mesh's edges and over the two triangles beside each edge. They exceed
/// true geodesics by a few percent, which weights by distance do not feel.
class SurfaceDistance {
public:
    /// Only triangles whose surface is set in `surfaces` (bit s: Surface(s)) carry paths.
    SurfaceDistance(const Mesh& mesh, std::uint32_t surfaces);

    struct Reached {
        std::uint32_t vertex;
        float distance;  ///< mm
    };
    /// All vertices within `limit` mm of the seeds (vertex, starting distance), nearest first.
    std::vector<Reached> from(const std::vector<std::pair<std::uint32_t, float>>& seeds,
                              float limit = std::numeric_limits<float>::infinity()) const;

    bool carries(std::uint32_t vertex) const { return start_[vertex + 1] > start_[vertex]; }

private:
    std::vector<std::uint32_t> start_;              // V + 1
    std::vector<std::pair<std::uint32_t, float>> arcs_;  // to, length in mm
};

}  // namespace mien
