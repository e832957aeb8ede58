#pragma once

#include <filesystem>
#include <optional>

#include "core/result.hpp"
#include "samples/performance.hpp"

namespace mien::samples {

/// A Live Link Face CSV as a performance at the take's own rate; frames that the recording dropped are filled in by
/// interpolation, so that time stays true. The app's angles (radians, about -y, +x, -z, outermost first: yaw > 0 to the
/// actor's right, pitch > 0 down) turn the head about the top of the neck; the eyes' become Gaze (yaw > 0 left, pitch > 0 up). A take without eye angles looks where its EyeLook weights say. `sound`: a file that began with the take.
/// Errors: those of the files; missing when not one ARKit weight is there.
Result<Performance> perform_take(const std::filesystem::path& csv, const std::optional<std::filesystem::path>& sound = {});

}  // namespace mien::samples
