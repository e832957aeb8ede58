#pragma once

#include <filesystem>

#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::io {

/// WAV, FLAC and what else libsndfile reads, as float PCM in [-1, 1]. Errors: missing, damaged, limit_exceeded; invalid for more
/// than 8 channels or samples that are not finite.
Result<Sound> read_sound(const std::filesystem::path& path);

/// 16-bit PCM WAV; samples beyond [-1, 1] are clipped. Throws EnvironmentError.
void write_wav(const std::filesystem::path& path, const Sound& sound);

}  // namespace mien::io
