#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry.hpp"

namespace mien::model {

/// Two lips, or the two lids of an eye, which may touch and never cross. Both are held on their own side of one surface y = S(x, z) in head space that
/// runs between them, so they stay apart however they slide on each other, and nothing moves where they do not meet.
struct Contact {
    struct Member {
        std::uint32_t vertex;
        float hold;  ///< share of the push that it takes: > 0 stays above the surface, < 0 below; 0 < |hold| <= 1
    };
    std::vector<std::array<std::uint32_t, 2>> pairs;  ///< vertices that face each other across the slit: S runs through their middles
    std::vector<Member> members;
};

inline constexpr std::size_t kMaxContactPairs = 256;
/// S is the mean of the heights of the pairs' middles, weighted by 1 / (d² + reach²)², d: mm to the middle in x and z.
inline constexpr float kContactReach = 1.2f;
/// A member at a height h over S is lifted to h' = (h + softness)² / (4 softness) for |h| < softness, to 0 below that: once
/// differentiable in h, and never below S.
inline constexpr float kContactSoftness = 0.15f;

/// Pushes members of `points` (V x 3 mm, head space) along y, up to their own side of S.
void hold_apart(const Contact& contact, Points& points);

}  // namespace mien::model
