#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "core/progress.hpp"
#include "core/scan.hpp"

namespace mien::io {

/// A float picture in a file: OpenEXR (docs/clip.md). Errors name the path.
Result<FloatMap> read_exr(const std::filesystem::path& path);

/// Where the maps of a clip's scans are: each a folder or printf pattern of numbered OpenEXR files, one per frame.
struct ScanPaths {
    std::filesystem::path medium, fine;
    std::optional<std::filesystem::path> albedo;
    std::optional<std::filesystem::path> masks;  ///< numbered grey pictures: texels at 0 were not seen in that frame
};

struct OpenedScans {
    std::shared_ptr<const ScanSource> source;  ///< none if a fault leaves nothing to rely on
    std::vector<Error> faults;
};
/// Opens them; maps are read when asked for. `unit`: mm per unit of the files. Faults: missing (no file), mismatch (a number without its file,
/// counts that differ, a map that is not square or not as large as the first), those of the first frames.
OpenedScans open_scans(const ScanPaths& paths, double unit);

/// Writes the maps of `frames` frames as numbered OpenEXR files into the folders positions_medium, positions_fine and (if there is one)
/// albedo of `folder`. `unit`: mm per unit of the files. Error: a scan that cannot be read.
Result<void> write_scans(const std::filesystem::path& folder, const ScanSource& scans, std::int64_t frames, double unit, const Progress& progress);

}  // namespace mien::io
