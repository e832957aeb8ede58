#include "media/float_picture.hpp"

#include <array>
#include <cmath>

#include "media/ffmpeg.hpp"

namespace mien::media {
namespace {

constexpr std::array<int, 3> kPlanes{2, 0, 1};  // of R, G, B among FFmpeg's G, B, R

/// FFmpeg cuts the lower bits off; half of the last one that stays, added before, makes that rounding.
float rounded_to_half(float value) {
    if (!std::isfinite(value) || std::abs(value) < 0x1p-14f) return value;
    return value + std::copysign(std::ldexp(1.0f, std::ilogb(value) - 11), value);
}

int plane_of(int channel, int channels) { return channels == 1 ? 0 : kPlanes[std::size_t(channel)]; }

}  // namespace

Result<FloatMap> decode_exr(ByteView bytes) {
    quiet_libraries();
    constexpr unsigned kMagic[4] = {0x76, 0x2f, 0x31, 0x01};
    for (std::size_t i = 0; i < 4; ++i)
        if (bytes.size() < 4 || std::to_integer<unsigned>(bytes[i]) != kMagic[i]) return Error{ErrorCode::bad_magic, "not an OpenEXR picture"};
    const AVCodec* decoder = avcodec_find_decoder(AV_CODEC_ID_EXR);
    if (!decoder) return Error{ErrorCode::unavailable, "this FFmpeg decodes no OpenEXR"};
    const CodecPtr codec(allocated(avcodec_alloc_context3(decoder)));
    codec->max_pixels = most_pixels(bytes);
    codec->thread_count = 1;
    codec->err_recognition = AV_EF_EXPLODE;
    if (const int code = avcodec_open2(codec.get(), decoder, nullptr); code < 0) return av_error(code, "OpenEXR decoder failed");
    const PacketPtr packet = make_packet(bytes);
    if (const int code = avcodec_send_packet(codec.get(), packet.get()); code < 0) return av_error(code, "OpenEXR picture does not decode");
    avcodec_send_packet(codec.get(), nullptr);
    const FramePtr frame = make_frame();
    if (const int code = avcodec_receive_frame(codec.get(), frame.get()); code < 0) return av_error(code, "OpenEXR picture does not decode");
    if (frame->width > kMaxPictureSide || frame->height > kMaxPictureSide) return Error{ErrorCode::limit_exceeded, "OpenEXR picture has a side above 8192"};
    const bool grey = frame->format == AV_PIX_FMT_GRAYF32;
    if (!grey && frame->format != AV_PIX_FMT_GBRPF32 && frame->format != AV_PIX_FMT_GBRAPF32)
        return Error{ErrorCode::unsupported_version, "OpenEXR picture has other planes than R, G, B or Y"};
    FloatMap map(frame->width, frame->height, grey ? 1 : 3);
    for (int y = 0; y < map.height; ++y)
        for (int c = 0; c < map.channels; ++c) {
            const int plane = plane_of(c, map.channels);
            const auto* row = reinterpret_cast<const float*>(frame->data[plane] + std::ptrdiff_t(y) * frame->linesize[plane]);
            float* out = map.at(0, y) + c;
            for (int x = 0; x < map.width; ++x, out += map.channels) *out = row[x];
        }
    return map;
}

Result<Bytes> encode_exr(const FloatMap& map, ExrNumbers numbers) {
    assert((map.channels == 1 || map.channels == 3) && map.width > 0 && map.height > 0);
    quiet_libraries();
    const AVCodec* encoder = avcodec_find_encoder_by_name("exr");
    if (!encoder) return Error{ErrorCode::unavailable, "this FFmpeg encodes no OpenEXR (it came with 5.0)"};
    const CodecPtr codec(allocated(avcodec_alloc_context3(encoder)));
    codec->width = map.width;
    codec->height = map.height;
    codec->pix_fmt = map.channels == 1 ? AV_PIX_FMT_GRAYF32 : AV_PIX_FMT_GBRPF32;
    codec->time_base = {1, 1};
    codec->thread_count = 1;
    codec->flags |= AV_CODEC_FLAG_BITEXACT;
    const bool half = numbers == ExrNumbers::half;
    av_opt_set(codec->priv_data, "format", half ? "half" : "float", 0);
    av_opt_set(codec->priv_data, "compression", half ? "zip16" : "none", 0);
    if (const int code = avcodec_open2(codec.get(), encoder, nullptr); code < 0) return av_error(code, "OpenEXR encoder failed");
    const FramePtr frame = make_frame();
    frame->width = map.width;
    frame->height = map.height;
    frame->format = codec->pix_fmt;
    frame->pts = 0;
    if (const int code = av_frame_get_buffer(frame.get(), 0); code < 0) return av_error(code, "OpenEXR encoder failed");
    for (int y = 0; y < map.height; ++y)
        for (int c = 0; c < map.channels; ++c) {
            const int plane = plane_of(c, map.channels);
            auto* row = reinterpret_cast<float*>(frame->data[plane] + std::ptrdiff_t(y) * frame->linesize[plane]);
            const float* in = map.at(0, y) + c;
            for (int x = 0; x < map.width; ++x, in += map.channels) row[x] = half ? rounded_to_half(*in) : *in;
        }
    if (const int code = avcodec_send_frame(codec.get(), frame.get()); code < 0) return av_error(code, "OpenEXR encoder failed");
    avcodec_send_frame(codec.get(), nullptr);
    const PacketPtr packet = make_packet();
    if (const int code = avcodec_receive_packet(codec.get(), packet.get()); code < 0) return av_error(code, "OpenEXR encoder failed");
    const auto* first = reinterpret_cast<const std::byte*>(packet->data);
    return Bytes(first, first + packet->size);
}

}  // namespace mien::media
