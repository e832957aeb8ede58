#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/clip.hpp"
#include "io/finding.hpp"

namespace mien::io {

/// What clip.json says (docs/clip.md), or what a folder without one shows: which file is what. Paths are ready to open.
struct ClipDescription {
    using Path = std::filesystem::path;

    std::optional<Rational> frame_rate;
    std::optional<Unit> unit;
    std::optional<Path> neutral, vertices, markers, weights, head_pose, gaze, texture, sound;
    std::vector<Path> masks;                        ///< pictures, or one folder or pattern: masks of every scan
    std::optional<Path> positions_medium, positions_fine, albedo;  ///< scans
    std::vector<Take> takes;
    std::vector<Path> vertex_files, texture_files;  ///< numbered files found in a folder, instead of `vertices` and `texture`

    /// A file, or the numbers themselves, row by row.
    struct Numbers {
        std::optional<Path> file;
        std::vector<std::vector<double>> rows;
        bool given() const { return file || !rows.empty(); }
    };
    Numbers rigid, marker_sites;

    /// Either one mesh per weight (an empty path: no target), or a file of offsets, or a folder or GLB with named targets.
    struct Targets {
        std::vector<Path> meshes;
        std::optional<Path> file;
        std::vector<std::string> names;
        bool given() const { return file || !meshes.empty(); }
    };
    Targets blendshapes;
    std::vector<std::string> weight_names;
    std::set<std::string> unread;                   ///< keys whose values, or parts of them, could not be used
};

/// Parses clip.json. `folder`: what relative paths start from. What is wrong goes to `findings`; the rest is still returned, nothing
/// only if the text is no JSON object.
std::optional<ClipDescription> parse_description(std::string_view json, const std::filesystem::path& folder, Findings& findings);

/// Tells what a folder without clip.json, or a single file, holds.
ClipDescription guess_description(const std::filesystem::path& path, Findings& findings);

}  // namespace mien::io
