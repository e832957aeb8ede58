#include "io/image_file.hpp"

#include <fmt/format.h>

#include <climits>
#include <cstring>
#include <memory>
#include <string_view>

#include "core/environment_error.hpp"
#include "io/file.hpp"
#include "io/limits.hpp"
#include "io/text.hpp"
#include "media/picture.hpp"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_JPEG   // its Huffman tables are not bounded before 2023: FFmpeg reads JPEG
#define STBI_NO_GIF
#define STBI_NO_HDR
#define STBI_NO_PSD
#define STBI_NO_PIC
#define STBI_NO_PNM
#define STBI_MAX_DIMENSIONS 8192
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wshadow"
#include <stb_image.h>
#include <stb_image_write.h>
#pragma GCC diagnostic pop

static_assert(mien::io::kMaxImageSide == STBI_MAX_DIMENSIONS);

namespace mien::io {
namespace {

struct StbFree {
    void operator()(stbi_uc* pixels) const { stbi_image_free(pixels); }
};

const stbi_uc* as_stb(ByteView bytes) { return reinterpret_cast<const stbi_uc*>(bytes.data()); }

Error stb_error() {
    const char* reason = stbi_failure_reason();
    return {ErrorCode::damaged, fmt::format("the picture cannot be decoded: {}", reason ? reason : "unknown reason")};
}

/// The decoder makes room for a PNG chunk before it looks whether the file has one so long, and copies one without bytes to where it
/// has made no room yet.
Result<void> check_chunks(ByteView bytes) {
    constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n";
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!text.starts_with(kPng)) return {};
    bool has_pixels = false;
    for (std::size_t at = kPng.size(); at + 8 <= bytes.size();) {
        std::uint64_t length = 0;
        for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<std::uint64_t>(bytes[at + i]);
        if (text.substr(at + 4, 4) == "IEND") break;
        if (text.substr(at + 4, 4) == "IDAT") {
            if (length == 0 && !has_pixels) return Error{ErrorCode::damaged, "the PNG file's first IDAT chunk is empty"};
            has_pixels = true;
        }
        if (length + 12 > bytes.size() - at) return Error{ErrorCode::truncated, "the PNG file ends inside a chunk"};
        at += std::size_t(length) + 12;
    }
    return {};
}

bool is_jpeg(ByteView bytes) {
    constexpr std::string_view kStart = "\xff\xd8\xff";
    return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).starts_with(kStart);
}

Image grey_of(const Image& rgb) {
    Image grey(rgb.width, rgb.height, 1);
    for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
        const std::uint8_t* p = &rgb.pixels[3 * i];
        grey.pixels[i] = std::uint8_t((77 * p[0] + 150 * p[1] + 29 * p[2]) >> 8);   // BT.601, as stb does with other formats
    }
    return grey;
}

Result<ImageSize> parse_image_size(ByteView bytes) {
    ImageSize size;
    if (bytes.size() > INT_MAX) return Error{ErrorCode::limit_exceeded, "the picture file is larger than 2 GB"};
    if (!stbi_info_from_memory(as_stb(bytes), int(bytes.size()), &size.width, &size.height, &size.channels)) return stb_error();
    if (size.width < 1 || size.height < 1 || size.width > kMaxImageSide || size.height > kMaxImageSide)
        return Error{ErrorCode::limit_exceeded, fmt::format("the picture is {} x {}, more than {} a side", size.width, size.height, kMaxImageSide)};
    // stb paints on behind the end of a TGA file. The densest format it reads, PNG of one bit a pixel, holds 8 x 1032 pixels a byte.
    constexpr std::int64_t kMostPixelsAByte = 10'000;
    if (std::int64_t(size.width) * size.height > kMostPixelsAByte * std::int64_t(bytes.size()))
        return Error{ErrorCode::truncated, fmt::format("the picture file has {} bytes, too few for {} x {} pixels", bytes.size(), size.width, size.height)};
    return size;
}

void append_to(void* context, void* from, int size) {
    const auto* bytes = static_cast<const std::byte*>(from);
    auto& to = *static_cast<Bytes*>(context);
    to.insert(to.end(), bytes, bytes + size);
}

}  // namespace

Result<Image> parse_image(ByteView bytes, int channels, bool* had_alpha) {
    assert(channels == 1 || channels == 3);
    if (is_jpeg(bytes)) {
        MIEN_TRY(picture, media::decode_picture(bytes));
        if (had_alpha) *had_alpha = false;
        return channels == 1 ? grey_of(picture) : std::move(picture);
    }
    MIEN_TRY(size, parse_image_size(bytes));
    MIEN_CHECK(check_chunks(bytes));
    int width = 0, height = 0, there = 0;
    const std::unique_ptr<stbi_uc, StbFree> pixels(
        stbi_load_from_memory(as_stb(bytes), int(bytes.size()), &width, &height, &there, channels));
    if (!pixels || width != size.width || height != size.height) return stb_error();
    Image image(size.width, size.height, channels);
    std::memcpy(image.pixels.data(), pixels.get(), image.pixels.size());
    if (had_alpha) *had_alpha = there == 2 || there == 4;
    return image;
}

Result<Image> read_image(const std::filesystem::path& path, int channels, bool* had_alpha) {
    MIEN_TRY(bytes, read_bytes(path));
    auto image = parse_image(bytes, channels, had_alpha);
    if (!image) return in_file(path, image.error());
    return image;
}

Result<ImageSize> read_image_size(const std::filesystem::path& path) {
    MIEN_TRY(bytes, read_bytes(path));
    if (is_jpeg(bytes)) {
        MIEN_TRY(picture, read_image(path));
        return ImageSize{picture.width, picture.height, picture.channels};
    }
    auto size = parse_image_size(bytes);
    if (!size) return in_file(path, size.error());
    return size;
}

void write_image(const std::filesystem::path& path, const Image& image, int jpeg_quality) {
    Bytes bytes;
    const std::string ending = lower_case(path.extension().string());
    const bool jpeg = ending == ".jpg" || ending == ".jpeg";
    const int written = jpeg ? stbi_write_jpg_to_func(append_to, &bytes, image.width, image.height, image.channels,
                                                      image.pixels.data(), jpeg_quality)
                             : stbi_write_png_to_func(append_to, &bytes, image.width, image.height, image.channels,
                                                      image.pixels.data(), image.width * image.channels);
    if (!written) throw EnvironmentError(fmt::format("cannot write {}: not enough memory to compress it", path.string()));
    write_file(path, bytes);
}

bool is_image_name(const std::filesystem::path& path) {
    const std::string ending = lower_case(path.extension().string());
    for (const char* known : {".png", ".jpg", ".jpeg", ".bmp", ".tga"})
        if (ending == known) return true;
    return false;
}

}  // namespace mien::io
