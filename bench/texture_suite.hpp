#pragma once

#include "bench/suite.hpp"

namespace mien::bench {

/// Texture rows of every codec and rate, ours and plain, and with them the drawn views when the clip has vertices and OpenGL
/// is there. What cannot be encoded is in a row's `failed`.
Result<void> run_textures(const Clip& clip, const std::string& key, const SuiteOptions& options, Report& report,
                          const std::function<void()>& save, const Progress& progress);

}  // namespace mien::bench
