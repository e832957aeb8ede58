#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/clip.hpp"

namespace mien::io {

/// A recording of the Live Link Face app: ARKit's blendshape weights, head and eye angles.
struct LiveLinkTake {
    Rational frame_rate;               ///< the nearest usual rate to what the timecodes say
    WeightSequence weights;            ///< every frame from first to last; names from the header, in its order
    std::vector<RigidPose> head_pose;  ///< per frame, rotation only; empty when the file has no head angles
    std::vector<Gaze> gaze;            ///< per frame; empty when the file has no eye angles
    std::int64_t rows = 0;             ///< rows recorded: weights.frames less the dropped frames, plus repeated ones
    std::vector<std::int64_t> dropped; ///< frames the recording lacks, filled by linear interpolation, ascending
    std::vector<std::int64_t> repeated;  ///< rows (from 0) whose timecode repeats the row before; left out
};

/// The nine angles of a frame (HeadYaw ... RightEyeRoll, radians) as pose and gaze.
RigidPose live_link_pose(const float* angles);
Gaze live_link_gaze(const float* angles);
/// ... and back, into the first three or the last six of nine angles.
void live_link_angles(const RigidPose& pose, float* angles);
void live_link_angles(const Gaze& gaze, float* angles);

/// Whether the first line looks like a Live Link Face header (Timecode, BlendShapeCount, ...).
bool is_live_link(std::string_view text);

/// Live Link Face CSV: Timecode HH:MM:SS:FF.sss, BlendShapeCount, weights, and up to nine angles (HeadYaw ... RightEyeRoll,
/// radians; turns about -y, +x, -z, in this order outermost first: yaw > 0 to the actor's right, pitch > 0 down). The frame number
/// of a row follows from its timecode, which may pass midnight. Errors: invalid naming the line, and of numbers that are not
/// finite every weight and frame; a gap of more than 10 s.
Result<LiveLinkTake> parse_live_link(std::string_view text);
Result<LiveLinkTake> read_live_link(const std::filesystem::path& path);

}  // namespace mien::io
