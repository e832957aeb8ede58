#include "bench/texture_codec.hpp"

#include <algorithm>
#include <cmath>

extern "C" {
#include <libavutil/avutil.h>
}

#include "decoder/av_texture.hpp"
#include "encoder/stream_encoder.hpp"
#include "encoder/texture_fill.hpp"
#include "media/video_encoder.hpp"

namespace mien::bench {
namespace {

constexpr double kGroupSeconds = 1;

protocol::Track track_of(const Clip& clip, const std::string& codec, Bytes codec_config, protocol::TextureInfo info) {
    protocol::Rung rung;
    rung.codec = codec;
    rung.codec_config = std::move(codec_config);
    return {protocol::TrackKind::texture, "texture", clip.frame_rate.inverse(), info, {std::move(rung)}};
}

struct Packets {
    Bytes codec_config;
    std::vector<media::VideoPacket> packets;
    double kbps = 0;
};

Result<Packets> encode_packets(const Clip& clip, encoder::TextureFill& fill, const media::VideoEncoderSettings& settings,
                               const Progress& progress) {
    MIEN_TRY(encoder, media::VideoEncoder::open(settings));
    Packets out;
    out.codec_config = encoder.codec_config();
    double bytes = double(out.codec_config.size());
    const auto keep = [&](std::vector<media::VideoPacket> packets) {
        for (media::VideoPacket& packet : packets) {
            bytes += double(packet.bytes.size());
            out.packets.push_back(std::move(packet));
        }
    };
    media::YuvImage yuv(settings.width, settings.height, media::Chroma::quarter);
    const std::int64_t frames = clip.texture->frames();
    for (std::int64_t f = 0; f < frames; ++f) {
        if (progress) progress("texture", f, frames);
        MIEN_TRY(picture, clip.texture->read(f));
        fill.apply(picture);
        media::to_yuv(picture, yuv);
        MIEN_TRY(packets, encoder.encode(yuv, f % settings.key_interval == 0));
        keep(std::move(packets));
    }
    MIEN_TRY(packets, encoder.finish());
    keep(std::move(packets));
    out.kbps = bytes * 8 / 1000 * clip.frame_rate.value() / double(frames);
    return out;
}

}  // namespace

std::uint64_t CodedTexture::bytes() const {
    std::uint64_t sum = track.rungs.front().codec_config.size();
    for (const protocol::Group& group : groups)
        for (const protocol::Object& object : group.objects) sum += object.bytes.size();
    return sum;
}

Result<CodedTexture> encode_ours(const Clip& clip, const std::string& codec, double kbps, const Progress& progress) {
    encoder::TextureOptions options;
    options.codec = codec;
    options.kbps = kbps;
    options.group_frames = encoder::group_frames(clip.frame_rate, kGroupSeconds);
    MIEN_TRY(encoded, encoder::encode_texture(clip, options, progress));
    encoder::EncodedTextureRung& rung = encoded.rungs.front();
    return CodedTexture{track_of(clip, codec, std::move(rung.codec_config), encoded.info), std::move(rung.groups)};
}

Result<CodedTexture> encode_plain(const Clip& clip, const std::string& codec, double kbps, const Progress& progress) {
    const int width = clip.texture->width(), height = clip.texture->height();
    encoder::TextureFill fill(width, height, encoder::used_texels(clip, width, height));
    media::VideoEncoderSettings settings;
    settings.codec = codec;
    settings.width = media::coded_side(width);
    settings.height = media::coded_side(height);
    settings.frame_rate = clip.frame_rate;
    settings.kbps = kbps;
    settings.key_interval = std::min(encoder::group_frames(clip.frame_rate, kGroupSeconds), clip.texture->frames());
    MIEN_TRY(best, encode_packets(clip, fill, settings, progress));
    for (int again = 0; again < 2 && std::abs(best.kbps / kbps - 1) > 0.08; ++again) {
        settings.kbps = std::clamp(*settings.kbps * kbps / best.kbps, kbps / 8, kbps * 8);
        MIEN_TRY(retry, encode_packets(clip, fill, settings, progress));
        if (std::abs(std::log(retry.kbps / kbps)) >= std::abs(std::log(best.kbps / kbps))) break;
        best = std::move(retry);
    }
    CodedTexture out{track_of(clip, codec, std::move(best.codec_config),
                              {std::uint32_t(width), std::uint32_t(height), YuvView::Matrix::bt709, false}),
                     {}};
    for (media::VideoPacket& packet : best.packets) {
        if (packet.frame % settings.key_interval == 0 && packet.key) {
            protocol::Group group;
            group.group = std::uint32_t(out.groups.size());
            group.first_time = packet.frame;
            out.groups.push_back(std::move(group));
        }
        if (out.groups.empty())
            return Error{ErrorCode::unavailable, "the " + codec + " encoder here does not start with a key frame"};
        out.groups.back().objects.push_back({1, std::move(packet.bytes)});
    }
    return out;
}

Result<void> decode_texture(const CodedTexture& texture, const std::function<Result<void>(std::int64_t, const Image&)>& picture) {
    MIEN_TRY(decoder, decoder::TextureDecoder::create(texture.track, texture.track.rungs.front()));
    const auto give = [&](const std::vector<decoder::TextureFrame>& frames) -> Result<void> {
        for (const decoder::TextureFrame& frame : frames) MIEN_CHECK(picture(frame.frame, decoder::to_rgb(frame.picture)));
        return {};
    };
    for (const protocol::Group& group : texture.groups) {
        decoder.begin_group(group.first_time);
        for (const protocol::Object& object : group.objects) {
            MIEN_TRY(frames, decoder.push(object));
            MIEN_CHECK(give(frames));
        }
        MIEN_TRY(frames, decoder.end_group(std::int64_t(group.objects.size())));
        MIEN_CHECK(give(frames));
    }
    return {};
}

std::string texture_library() {
    return std::string("FFmpeg ") + av_version_info();
}

}  // namespace mien::bench
