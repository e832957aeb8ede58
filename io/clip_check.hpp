#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry.hpp"
#include "core/progress.hpp"
#include "core/rational.hpp"
#include "io/finding.hpp"

namespace mien::io {

/// What is in a clip and what is wrong with it.
struct ClipReport {
    std::string name;
    std::string unit;              ///< of the files
    Rational frame_rate;
    std::int64_t frames = 0;
    double seconds = 0;
    std::int64_t vertices = 0, triangles = 0, texcoords = 0;  ///< of the mesh
    std::int64_t vertex_frames = 0;                           ///< 0: no vertex motion
    std::int64_t markers = 0, marker_sites = 0;
    double markers_present = 1;    ///< share of markers and frames that are there
    std::int64_t weights = 0, blendshapes = 0;
    std::int64_t rigid = 0;
    bool head_pose = false, gaze = false, mask = false;
    bool has_box = false;
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< box around the motion (the neutral mesh if nothing has positions), mm
    int texture_width = 0, texture_height = 0;
    std::int64_t texture_frames = 0;
    int scan_medium_size = 0, scan_fine_size = 0;  ///< texels per side; 0: no scans
    bool scan_albedo = false;
    std::int64_t scan_frames = 0, takes = 0;
    double scan_seen = 0;          ///< share of the medium maps' texels that were seen
    int sound_rate = 0, sound_channels = 0;
    double sound_seconds = 0;
    std::vector<Finding> findings;

    bool good() const;             ///< no finding is a problem
    std::string text() const;      ///< for people, several lines
    std::string json() const;      ///< the same for scripts
};

/// Reads all of a clip, every frame of its texture too, and lists every inconsistency by name and frame; those of one kind are
/// listed together. A size that fits no head is a problem here.
ClipReport check_clip(const std::filesystem::path& path, const Progress& progress = {});

}  // namespace mien::io
