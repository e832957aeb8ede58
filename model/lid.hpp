#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.hpp"

namespace mien::model {

/// The skin of one eye's upper lid, with lashes and all that hangs on it, where markers move the base shape. A lid is a sheet that
/// slides over the eyeball: its margin goes all the way and its fold stays. Markers sit between the two and show a share of the way only,
/// which no mean of markers can exceed.
struct Lid {
    struct Member {
        std::uint32_t vertex;
        float share;   ///< of the lid's way: 1 at the margin, 0 from the fold on, more for what stands off from the skin
        float weight;  ///< 0 .. 1, of this against what the base shape has of its own
        float hold;    ///< 0 .. 1, share of the way back to its distance from `centre` at neutral
    };
    Vec3 centre = Vec3::Zero();   ///< of the eyeball, mm, head space
    std::vector<Member> members;  ///< ascending vertices
};

/// Markers that see less of a lid's way say nothing of it.
inline constexpr float kLeastLidShare = 0.15f;

/// Turns what a base shape has moved straight into a slide over the eyeball: members of `points` (V x 3 mm, head space) go towards or
/// away from the centre, by `hold` to the distance that they have in `neutral` (V x 3 mm).
void keep_on_eyeball(const Lid& lid, const Points& neutral, Points& points);

}  // namespace mien::model
