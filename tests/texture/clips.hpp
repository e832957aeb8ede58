#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "core/clip.hpp"
#include "decoder/av_texture.hpp"
#include "encoder/texture_encoder.hpp"

namespace mien::texture_test {

/// A texture whose frames are written down: smooth colour waves that move, with a hard edge, in memory.
class PaintedTexture : public TextureSource {
public:
    PaintedTexture(int width, int height, std::int64_t frames, int channels = 3)
        : width_(width), height_(height), frames_(frames), channels_(channels) {}
    int width() const override { return width_; }
    int height() const override { return height_; }
    std::int64_t frames() const override { return frames_; }
    Result<Image> read(std::int64_t frame) override { return paint(frame); }

    Image paint(std::int64_t frame) const {
        Image image(width_, height_, channels_);
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x) {
                const double t = double(frame) * 0.2, u = 6.3 * x / 100, v = 6.3 * y / 100;
                const double wave[3] = {150 + 60 * std::sin(u + t), 120 + 50 * std::sin(v - t),
                                        100 + 40 * std::cos(u + v + t)};
                const bool lip = std::abs(y - height_ / 2) < 3 + 2 * std::sin(t);
                for (int c = 0; c < channels_; ++c)
                    image.at(x, y)[c] =
                        c == 3 ? std::uint8_t(x * 7 + y) : std::uint8_t(wave[c] * (lip ? 0.6 : 1));
            }
        return image;
    }

private:
    int width_, height_;
    std::int64_t frames_;
    int channels_;
};

inline Clip painted_clip(int width, int height, std::int64_t frames, int channels = 3) {
    Clip clip;
    clip.texture = std::make_shared<PaintedTexture>(width, height, frames, channels);
    return clip;
}

inline protocol::Track track_of(const encoder::EncodedTexture& encoded) {
    protocol::Track track;
    track.kind = protocol::TrackKind::texture;
    track.info = encoded.info;
    for (const encoder::EncodedTextureRung& encoded_rung : encoded.rungs) {
        protocol::Rung rung;
        rung.codec = encoded.codec;
        rung.codec_config = encoded_rung.codec_config;
        if (encoded_rung.width != int(encoded.info.width))
            rung.size = {std::uint32_t(encoded_rung.width), std::uint32_t(encoded_rung.height)};
        track.rungs.push_back(rung);
    }
    return track;
}

inline decoder::TextureDecoder decoder_of(const encoder::EncodedTexture& encoded, int threads = 0, std::size_t rung = 0) {
    const protocol::Track track = track_of(encoded);
    return std::move(*decoder::TextureDecoder::create(track, track.rungs[rung], threads));
}

/// All pictures of one group, through a decoder that may have decoded anything before.
inline Result<std::vector<decoder::TextureFrame>> decode_group(decoder::TextureDecoder& decoder,
                                                               const protocol::Group& group) {
    decoder.begin_group(group.first_time);
    std::vector<decoder::TextureFrame> all;
    for (const protocol::Object& object : group.objects) {
        MIEN_TRY(frames, decoder.push(object));
        all.insert(all.end(), frames.begin(), frames.end());
    }
    MIEN_TRY(rest, decoder.end_group(std::int64_t(group.objects.size())));
    all.insert(all.end(), rest.begin(), rest.end());
    return all;
}

inline std::uint64_t bytes_of(const encoder::EncodedTexture& encoded, std::size_t rung = 0) {
    std::uint64_t bytes = encoded.rungs[rung].codec_config.size();
    for (const auto& group : encoded.rungs[rung].groups)
        for (const auto& object : group.objects) bytes += object.bytes.size();
    return bytes;
}

}  // namespace mien::texture_test
