#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image.hpp"

namespace mien::io {

struct OpenedTexture {
    std::shared_ptr<TextureSource> source;
    std::vector<std::string> notes;  ///< alpha that is left out and the like
    std::optional<Error> fault;      ///< numbers without their file; the one before stands for it
};

/// A picture (one frame, static), a folder or printf pattern of numbered pictures, or any video FFmpeg reads. Errors: missing,
/// damaged, mismatch (most numbers lack their file).
Result<OpenedTexture> open_texture(const std::filesystem::path& path);

/// Pictures that each hold one frame. All have the size of the first; reading another size is an error naming the file.
Result<OpenedTexture> open_pictures(std::vector<std::filesystem::path> paths);

/// A texture that is in memory.
std::shared_ptr<TextureSource> texture_of(std::vector<Image> frames);

/// Endings (lower case) taken for pictures and for videos.
const std::vector<std::string>& image_endings();
const std::vector<std::string>& video_endings();

}  // namespace mien::io
