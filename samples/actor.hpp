#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "core/clip.hpp"

/// The digital stage: actors, performances, cameras and lights with known truth.
namespace mien::samples {

/// The 52 blendshapes of ARKit face tracking, in the column order of a Live Link Face CSV. Both actors take them, so one
/// take drives either.
inline constexpr int kArkitCount = 52;
extern const std::array<std::string_view, kArkitCount> kArkitNames;  // "EyeBlinkLeft", "EyeLookDownLeft", ..., "TongueOut"
int arkit_index(std::string_view name);                               // -1: no such name

/// What an actor does at one instant.
struct Instant {
    std::array<float, kArkitCount> weights{};  ///< 0 .. 1 (takes overshoot a little)
    RigidPose head;                            ///< head -> clip space, mm
    Gaze gaze;
};

/// Where features lie on the neutral mesh, so that skin can be painted and markers placed on any actor. Polylines are
/// positions in head space, mm; left and right are the actor's own (left = +x).
struct Landmarks {
    using Line = std::vector<Vec3>;
    Line brow[2];                 ///< [0] right, [1] left; inner end first
    Line upper_lid[2], lower_lid[2];  ///< lid margins, inner corner first
    Line upper_lip_outline, lower_lip_outline;  ///< vermilion border, right corner to left corner
    Line upper_lip_line, lower_lip_line;        ///< where the lips meet, right corner to left corner
    Vec3 eye_centre[2];           ///< eyeball centres, mm
    float eye_radius = 12;        ///< mm
    Vec3 nose_tip, nostril[2], chin, glabella, cheek[2], ear[2];
};

/// A head that can be posed: the truth of every sample performance.
class Actor {
public:
    virtual ~Actor() = default;
    virtual const Mesh& neutral() const = 0;                       ///< mm, head space; one UV atlas
    virtual const Landmarks& landmarks() const = 0;
    virtual const std::vector<std::uint32_t>& rigid_vertices() const = 0;  ///< move with the skull alone
    /// Positions of all vertices in head space (no head pose), V x 3 mm; eyeballs turned by gaze.
    virtual Points deform(const Instant& instant) const = 0;
};

}  // namespace mien::samples
