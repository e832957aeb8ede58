#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/clip.hpp"
#include "core/progress.hpp"
#include "io/finding.hpp"

namespace mien::io {

struct LoadedClip {
    Clip clip;
    std::vector<std::string> warnings;  ///< for people; one sentence each, long lists cut short
};

struct LoadOptions {
    std::optional<Rational> frame_rate;  ///< instead of what the files say
    std::optional<Unit> unit;            ///< of files that do not say it themselves
    Progress progress;
};

/// Loads a clip folder (docs/clip.md), a plain folder of numbered meshes or a single recording. Everything in `clip` is in mm
/// and consistent: counts agree, indices are in range, vertices and weights are finite, missing markers are NaN. The first
/// problem is the error; it names file, frame and point, and says how many more there are.
Result<LoadedClip> load_clip(const std::filesystem::path& path, const LoadOptions& options = {});

/// The same, but goes on after a problem and returns all that was found.
struct ClipReading {
    Clip clip;                    ///< what could be read; not to be relied on when there are problems
    Findings findings;
};
ClipReading read_clip(const std::filesystem::path& path, const LoadOptions& options = {});

struct WriteOptions {
    bool overwrite = false;  ///< replace the files of a clip that is there already
    bool texture_video = false;  ///< a moving texture as one lossless video, not as numbered PNGs
    Progress progress;
};

/// Writes a clip folder: clip.json, NPY arrays, OBJ meshes, numbered PNGs (one PNG if static) and WAV, lengths in clip.unit.
/// Everything is first written beside `path` and then moved there, clip.json last; what a killed process left beside it is
/// cleared away. Error: a frame of clip.texture that
/// cannot be read. Throws EnvironmentError when the folder is there with something in it and `overwrite` is not set, or
/// when writing fails; what was there before is then still there.
Result<void> write_clip(const std::filesystem::path& path, const Clip& clip, const WriteOptions& options = {});

}  // namespace mien::io
