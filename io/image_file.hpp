#pragma once

#include <filesystem>

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

namespace mien::io {

/// PNG, JPEG, BMP or TGA as RGB (channels 3) or grey (channels 1), 8 bit. Transparency is
/// dropped, 16-bit files are rounded to 8. `had_alpha`, when given, tells that there was an alpha channel.
Result<Image> parse_image(ByteView bytes, int channels = 3, bool* had_alpha = nullptr);
Result<Image> read_image(const std::filesystem::path& path, int channels = 3, bool* had_alpha = nullptr);

/// Width, height and channels; of JPEG three.
struct ImageSize {
    int width = 0, height = 0, channels = 0;
};
Result<ImageSize> read_image_size(const std::filesystem::path& path);

/// Writes PNG, or JPEG (quality 1 .. 100) when the name ends in .jpg or .jpeg. Throws EnvironmentError.
void write_image(const std::filesystem::path& path, const Image& image, int jpeg_quality = 95);

/// Whether the name's ending is one read_image knows.
bool is_image_name(const std::filesystem::path& path);

}  // namespace mien::io
