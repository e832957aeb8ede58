#include "io/texture_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/image_file.hpp"
#include "io/numbered_files.hpp"
#include "io/text.hpp"
#include "media/video_reader.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

class Pictures : public TextureSource {
public:
    Pictures(std::vector<fs::path> paths, ImageSize size) : paths_(std::move(paths)), size_(size) {}

    int width() const override { return size_.width; }
    int height() const override { return size_.height; }
    std::int64_t frames() const override { return std::int64_t(paths_.size()); }
    Result<Image> read(std::int64_t frame) override {
        if (frame < 0 || frame >= frames())
            return Error{ErrorCode::missing, fmt::format("the texture has no frame {}", frame)};
        if (frame == kept_) return last_;
        const fs::path& path = paths_[std::size_t(frame)];
        MIEN_TRY(image, read_image(path));
        if (image.width != size_.width || image.height != size_.height)
            return Error{ErrorCode::mismatch, fmt::format("{} is {} x {}, but the first picture is {} x {}", path.string(), image.width, image.height,
                                                          size_.width, size_.height)};
        last_ = std::move(image);
        kept_ = frame;
        return last_;
    }

private:
    std::vector<fs::path> paths_;
    ImageSize size_;
    Image last_;
    std::int64_t kept_ = -1;
};

class Remembered : public TextureSource {
public:
    explicit Remembered(std::vector<Image> frames) : frames_(std::move(frames)) { assert(!frames_.empty()); }
    int width() const override { return frames_[0].width; }
    int height() const override { return frames_[0].height; }
    std::int64_t frames() const override { return std::int64_t(frames_.size()); }
    Result<Image> read(std::int64_t frame) override {
        if (frame < 0 || frame >= frames()) return Error{ErrorCode::missing, fmt::format("the texture has no frame {}", frame)};
        return frames_[std::size_t(frame)];
    }

private:
    std::vector<Image> frames_;
};

}  // namespace

const std::vector<std::string>& image_endings() {
    static const std::vector<std::string> endings{".png", ".jpg", ".jpeg", ".bmp", ".tga"};
    return endings;
}

const std::vector<std::string>& video_endings() {
    static const std::vector<std::string> endings{".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".nut", ".y4m", ".mpg", ".ts"};
    return endings;
}

Result<OpenedTexture> open_pictures(std::vector<fs::path> paths) {
    MIEN_TRY(size, read_image_size(paths.at(0)));
    OpenedTexture opened;
    if (size.channels == 2 || size.channels == 4)
        opened.notes.push_back(fmt::format("{} has an alpha channel, which is left out", paths[0].string()));
    opened.source = std::make_shared<Pictures>(std::move(paths), size);
    return opened;
}

Result<OpenedTexture> open_texture(const fs::path& path) {
    const std::string ending = lower_case(path.extension().string());
    const auto& images = image_endings();
    std::error_code ignored;
    if (!fs::is_directory(path, ignored) && fs::exists(path, ignored)) {
        if (std::find(images.begin(), images.end(), ending) != images.end()) return open_pictures({path});
        MIEN_TRY(video, media::VideoReader::open(path));
        return OpenedTexture{std::shared_ptr<TextureSource>(std::move(video)), {}};
    }
    MIEN_TRY(files, open_numbered(path, images));
    MIEN_TRY(opened, open_pictures(std::move(files.paths)));
    opened.fault = std::move(files.fault);
    return std::move(opened);
}

std::shared_ptr<TextureSource> texture_of(std::vector<Image> frames) { return std::make_shared<Remembered>(std::move(frames)); }

}  // namespace mien::io
