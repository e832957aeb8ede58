#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace mien::analysis {

/// Markers of another session on a model's face.
struct PlacedMarkers {
    std::vector<Site> sites;          ///< the nearest points of the skin
    Points rest;                      ///< M x 3 mm, the markers at rest in the model's space
    double mean = 0, largest = 0;     ///< mm, of the markers from the skin
};

/// Lays markers at rest (M x 3 mm, all there) on the skin of `neutral`, the same actor's face. The two spaces may differ by a rigid motion, of up to a
/// third of a turn or so: it is found by iterated closest points (to tangent planes: Chen and Medioni 1992), from as they are and from equal middles. `surface`: points of the
/// other session's face mesh in the space of the markers, which hold the fit better than the markers alone; none: those alone.
PlacedMarkers place_markers(const Mesh& neutral, PointsRef markers, PointsRef surface);

/// The same markers believed to sit `mm` away along the skin, each in a direction of its own: what a wrong placement costs can then be measured.
void misplace(PlacedMarkers& placed, const Mesh& neutral, double mm, std::uint32_t seed);

}  // namespace mien::analysis
