#include "encoder/texture_encoder.hpp"

#include <algorithm>
#include <cmath>

#include "encoder/texture_fill.hpp"
#include "media/video_encoder.hpp"
#include "protocol/limits.hpp"

namespace mien::encoder {
namespace {

struct Run {
    Bytes codec_config;
    std::vector<media::VideoPacket> packets;

    double kbps(Rational frame_rate, std::int64_t frames) const {
        double bits = 8.0 * double(codec_config.size());
        for (const media::VideoPacket& packet : packets) bits += 8.0 * double(packet.bytes.size());
        return bits / 1000 * frame_rate.value() / double(frames);
    }
};

Image as_rgb(Image picture) {
    if (picture.channels == 3) return picture;
    Image rgb(picture.width, picture.height, 3);
    for (std::size_t i = 0; i < std::size_t(rgb.width) * rgb.height; ++i)
        for (int c = 0; c < 3; ++c)
            rgb.pixels[3 * i + c] = picture.pixels[i * picture.channels + (picture.channels < 3 ? 0 : c)];
    return rgb;
}

Result<Run> encode_once(TextureSource& source, TextureFill& fill, const media::VideoEncoderSettings& settings,
                        const Progress& progress) {
    MIEN_TRY(encoder, media::VideoEncoder::open(settings));
    Run run;
    run.codec_config = encoder.codec_config();
    const auto keep = [&](std::vector<media::VideoPacket>& packets) {
        std::move(packets.begin(), packets.end(), std::back_inserter(run.packets));
    };
    media::YuvImage yuv(settings.width, settings.height, media::Chroma::quarter, YuvView::Matrix::bt709,
                        settings.full_range);
    const std::int64_t frames = source.frames();
    for (std::int64_t f = 0; f < frames; ++f) {
        if (progress) progress("texture", f, frames);
        MIEN_TRY(read, source.read(f));
        if (read.width != source.width() || read.height != source.height())
            return Error{ErrorCode::mismatch,
                         "texture frame " + std::to_string(f) + " is " + std::to_string(read.width) + " x " +
                             std::to_string(read.height) + ", the first one " +
                             std::to_string(source.width()) + " x " + std::to_string(source.height())};
        Image picture = as_rgb(std::move(read));
        fill.apply(picture);
        media::to_yuv(picture, yuv);
        MIEN_TRY(packets, encoder.encode(yuv, f % settings.key_interval == 0));
        keep(packets);
    }
    MIEN_TRY(packets, encoder.finish());
    keep(packets);
    if (progress) progress("texture", frames, frames);
    return run;
}

/// Packets into groups, held against what a group promises: it starts with the key frame of its first picture
/// and holds exactly its own pictures.
Result<std::vector<protocol::Group>> group_packets(std::vector<media::VideoPacket> packets,
                                                   std::int64_t frames, std::int64_t group_frames,
                                                   const std::string& codec) {
    std::vector<protocol::Group> groups;
    for (media::VideoPacket& packet : packets) {
        const std::int64_t number = packet.frame / group_frames;
        if (number == std::int64_t(groups.size()) && packet.key && packet.frame == number * group_frames) {
            protocol::Group group;
            group.group = std::uint32_t(number);
            group.first_time = packet.frame;
            groups.push_back(std::move(group));
        }
        if (number + 1 != std::int64_t(groups.size()))
            return Error{ErrorCode::unavailable,
                         "the " + codec +
                             " encoder here does not start closed groups where it is told to (frame " +
                             std::to_string(packet.frame) + ")"};
        groups.back().objects.push_back({1, std::move(packet.bytes)});
    }
    for (std::size_t g = 0; g < groups.size(); ++g)
        if (std::int64_t(groups[g].objects.size()) !=
            std::min(group_frames, frames - std::int64_t(g) * group_frames))
            return Error{
                ErrorCode::unavailable,
                "the " + codec + " encoder here drops or repeats pictures in group " + std::to_string(g)};
    return groups;
}

}  // namespace

std::vector<std::string> texture_codecs() {
    return media::VideoEncoder::available();
}

Result<EncodedTexture> encode_texture(const Clip& clip, const TextureOptions& options,
                                      const Progress& progress) {
    assert(clip.texture);
    TextureSource& source = *clip.texture;
    const int width = source.width(), height = source.height();
    const std::int64_t frames = source.frames();
    if (frames < 1 || width < 1 || height < 1) return Error{ErrorCode::invalid, "texture has no frames"};
    if (width > int(protocol::kMaxTextureSide) || height > int(protocol::kMaxTextureSide))
        return Error{ErrorCode::limit_exceeded, "texture of " + std::to_string(width) + " x " +
                                                    std::to_string(height) + " texels is larger than " +
                                                    std::to_string(protocol::kMaxTextureSide) + " on a side"};
    if (options.kbps && options.quality)
        return Error{ErrorCode::invalid, "texture takes a bitrate or a quality, not both"};
    if (options.kbps && !(*options.kbps >= 1 && *options.kbps <= 2e6))
        return Error{ErrorCode::invalid, "texture bitrate must be 1 to 2 000 000 kbit/s"};
    if (options.quality && !(*options.quality >= 0 && *options.quality <= 100))
        return Error{ErrorCode::invalid, "texture quality must be 0 to 100"};

    media::VideoEncoderSettings settings;
    settings.codec = options.codec;
    settings.width = media::coded_side(width);
    settings.height = media::coded_side(height);
    settings.frame_rate = clip.frame_rate;
    settings.kbps = options.kbps;
    settings.quality = options.quality.value_or(settings.quality);
    settings.speed = options.speed;
    const std::int64_t group_frames =
        options.group_frames > 0 ? std::min(options.group_frames, frames) : frames;
    settings.key_interval = group_frames;

    TextureFill fill(width, height, used_texels(clip, width, height));
    MIEN_TRY(run, encode_once(source, fill, settings, progress));
    // Rate control starts cold and a clip is short: where it misses, ask for what makes up for it.
    constexpr double kTolerance = 0.08;
    for (int again = 0; options.kbps && again < 2; ++again) {
        const double got = run.kbps(clip.frame_rate, frames), ratio = *options.kbps / got;
        if (std::abs(got / *options.kbps - 1) <= kTolerance) break;
        settings.kbps = std::clamp(*settings.kbps * ratio, *options.kbps / 8, *options.kbps * 8);
        MIEN_TRY(retry, encode_once(source, fill, settings, progress));
        const double now = retry.kbps(clip.frame_rate, frames);
        if (std::abs(std::log(now / *options.kbps)) < std::abs(std::log(got / *options.kbps)))
            run = std::move(retry);
        else
            break;
    }

    EncodedTexture out;
    out.info = {std::uint32_t(width), std::uint32_t(height), YuvView::Matrix::bt709, settings.full_range};
    out.codec = options.codec;
    out.codec_config = std::move(run.codec_config);
    MIEN_TRY(groups, group_packets(std::move(run.packets), frames, group_frames, options.codec));
    out.groups = std::move(groups);
    return out;
}

}  // namespace mien::encoder
