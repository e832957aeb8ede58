#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/clip.hpp"
#include "io/finding.hpp"

namespace mien::io {

/// Where the parts of a clip came from, for messages: file names, or empty.
struct ClipSources {
    std::string vertices = "vertices", markers = "markers", weights = "weights", neutral = "neutral", texture = "texture", sound = "sound",
                head_pose = "head_pose", gaze = "gaze", marker_sites = "marker_sites", rigid = "rigid";
    std::vector<std::string> vertex_frames;  ///< the file of each frame, when each has its own
    bool unit_asked = false;                 ///< the unit is none of the files' but asked for
    /// Keys of clip.json that are named but could not be read, "fps" and "unit" also when only such a part would have told them.
    /// What depends on them is not judged: the cause has been reported.
    std::set<std::string> unread;
};

/// Largest side of the bounding box of the present points, mm; nothing when no point is present.
std::optional<double> extent(PointsRef points);
/// Of the points in the middle one of up to 100 frames by size: neither missing markers nor a stray frame tell much. Nothing for
/// fewer than four points.
std::optional<double> usual_extent(const PointSequence& points);
/// Of the whole clip: its neutral, else vertices or markers.
std::optional<double> head_size(const Clip& clip);
/// The unit in which a head of `size` file units would have the size of a head, if there is one.
std::optional<Unit> plausible_unit(double size);

/// Holds every promise of core/clip.hpp against the clip; problems and warnings go to `findings`. A size that is no head's (below 50 mm
/// or above 1 m) is a grave warning.
void validate(const Clip& clip, const ClipSources& sources, Findings& findings);

}  // namespace mien::io
