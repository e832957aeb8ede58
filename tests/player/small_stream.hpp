#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "encoder/stream_encoder.hpp"
#include "protocol/stream_file.hpp"
#include "tests/render/test_models.hpp"
#include "tests/temporary_folder.hpp"

namespace mien::player {

/// Grey pictures whose brightness tells their frame: 40 + 8 f.
class NumberedTexture final : public TextureSource {
public:
    explicit NumberedTexture(std::int64_t frames) : frames_(frames) {}
    int width() const override { return 64; }
    int height() const override { return 64; }
    std::int64_t frames() const override { return frames_; }
    Result<Image> read(std::int64_t frame) override {
        Image image(64, 64, 3);
        std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t(40 + 8 * frame));
        return image;
    }

private:
    std::int64_t frames_;
};

inline constexpr std::int64_t kFrames = 20;   // at 10 frames/s, in groups of 5

/// A ball that grows by 0.5 mm a frame, with a numbered texture and two seconds of sound.
inline Clip small_clip(bool texture, bool sound) {
    Clip clip;
    clip.name = "ball";
    clip.frame_rate = {10, 1};
    clip.neutral = render::make_ball(90, 8, 12);
    clip.vertices.emplace(kFrames, clip.neutral->vertex_count());
    for (std::int64_t f = 0; f < kFrames; ++f) clip.vertices->frame(f) = clip.neutral->positions * (1 + 0.5f * float(f) / 90);
    if (texture) clip.texture = std::make_shared<NumberedTexture>(kFrames);
    if (sound) {
        clip.sound = Sound{48000, 1, std::vector<float>(96000)};
        for (std::size_t i = 0; i < clip.sound->samples.size(); ++i) clip.sound->samples[i] = 0.3f * std::sin(0.05f * float(i));
    }
    return clip;
}

inline encoder::EncodedStream small_stream(bool texture = true, bool sound = true, std::optional<double> group = 0.5, int rungs = 1) {
    encoder::StreamOptions options;
    options.motion.rungs = rungs;
    options.motion.peak = 0.24;   // no frame is to be taken for its neighbour, 0.5 mm away
    options.group_seconds = group;
    auto stream = encoder::encode_stream(small_clip(texture, sound), options);
    if (!stream.ok()) throw std::runtime_error(stream.error().message);
    return std::move(*stream);
}

using tests::TemporaryFolder;

/// Writes the stream as a stored file and names it.
inline std::string store(const encoder::EncodedStream& stream, const TemporaryFolder& folder) {
    const std::filesystem::path path = folder / "ball.mien";
    std::ofstream file(path, std::ios::binary);
    protocol::StreamFileWriter writer(
        [&](ByteView bytes) { file.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size())); },
        stream.header, stream.blobs);
    for (const protocol::Group& group : stream.groups) writer.add(group);
    writer.finish();
    return path.string();
}

}  // namespace mien::player
