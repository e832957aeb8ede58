#pragma once

#include <cstdint>
#include <vector>

#include "core/clip.hpp"
#include "samples/actor.hpp"

namespace mien::samples {

inline constexpr int kMarkerCount = 182;  ///< as in Guenter et al. 1998, section 3

/// Places `count` markers on the actor's face, at distinct vertices: rows along lids, lips (upper and lower apart), brows,
/// nostrils and nasolabial furrows, then evenly over the front of the face (farthest-point sampling). Eyeballs, the inside
/// of mouth and lids, ears, neck and the back of the head have none. Fewer when the face has fewer vertices.
std::vector<Site> place_markers(const Actor& actor, int count = kMarkerCount, std::uint64_t seed = 0);

/// What a real capture does to markers.
struct MarkerFaults {
    double noise = 0;    ///< standard deviation of Gaussian noise in each coordinate, mm
    double missing = 0;  ///< share of samples lost, 0 .. 0.9, in gaps of 0.15 s on average
};

/// Adds the faults: noise to every coordinate, three NaNs where a marker is lost. Deterministic by seed.
void add_faults(PointSequence& markers, const MarkerFaults& faults, Rational frame_rate, std::uint64_t seed);

}  // namespace mien::samples
