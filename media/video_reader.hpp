#pragma once

#include <filesystem>
#include <memory>

#include "core/image.hpp"

namespace mien::media {

/// The frames of any video FFmpeg reads, by number in presentation order, as RGB by the video's own matrix,
/// range and chroma siting (BT.601 below 720 lines and limited range when it says nothing). The count is
/// exact: packets are counted when the file is opened, whatever its header claims. Ascending numbers decode
/// each picture once; others seek.
class VideoReader : public TextureSource {
public:
    /// `unavailable` when the file cannot be opened, `missing` when it has no video, `damaged` when nothing
    /// decodes.
    static Result<std::unique_ptr<VideoReader>> open(const std::filesystem::path& path);
    ~VideoReader() override;

    int width() const override;
    int height() const override;
    std::int64_t frames() const override;
    Result<Image> read(std::int64_t frame) override;

    /// Frames per second as the container or the codec says; 0/1 when neither does.
    Rational frame_rate() const;

private:
    struct State;
    explicit VideoReader(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace mien::media
