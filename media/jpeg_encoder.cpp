#include "media/ffmpeg.hpp"
#include "media/picture.hpp"

namespace mien::media {
namespace {

/// Full-range BT.601, as JFIF has it; one sample per texel, so nothing bleeds.
void fill_jfif(const Image& picture, AVFrame& frame) {
    const auto clamp = [](double v) { return std::uint8_t(v < 0 ? 0 : v > 255 ? 255 : v + 0.5); };
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            const std::uint8_t* p = picture.at(x, y);
            const double r = p[0], g = p[picture.channels > 1 ? 1 : 0], b = p[picture.channels > 1 ? 2 : 0];
            frame.data[0][y * frame.linesize[0] + x] = clamp(0.299 * r + 0.587 * g + 0.114 * b);
            frame.data[1][y * frame.linesize[1] + x] = clamp(128 - 0.168736 * r - 0.331264 * g + 0.5 * b);
            frame.data[2][y * frame.linesize[2] + x] = clamp(128 + 0.5 * r - 0.418688 * g - 0.081312 * b);
        }
}

}  // namespace

Result<Bytes> encode_jpeg(const Image& picture) {
    quiet_libraries();
    const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_MJPEG);
    if (!encoder) return Error{ErrorCode::unavailable, "this FFmpeg encodes no JPEG"};
    const CodecPtr codec(allocated(avcodec_alloc_context3(encoder)));
    codec->width = picture.width;
    codec->height = picture.height;
    codec->pix_fmt = AV_PIX_FMT_YUVJ444P;
    codec->color_range = AVCOL_RANGE_JPEG;
    codec->time_base = {1, 1};
    codec->thread_count = 1;
    codec->flags |= AV_CODEC_FLAG_QSCALE | AV_CODEC_FLAG_BITEXACT;
    constexpr int kScale = 2;  // the finest that stays within baseline tables
    codec->global_quality = FF_QP2LAMBDA * kScale;
    if (const int code = avcodec_open2(codec.get(), encoder, nullptr); code < 0)
        return av_error(code, "JPEG encoder failed");
    const FramePtr frame = make_frame();
    frame->width = picture.width;
    frame->height = picture.height;
    frame->format = codec->pix_fmt;
    frame->quality = codec->global_quality;
    frame->pts = 0;
    if (const int code = av_frame_get_buffer(frame.get(), 0); code < 0)
        return av_error(code, "JPEG encoder failed");
    fill_jfif(picture, *frame);
    if (const int code = avcodec_send_frame(codec.get(), frame.get()); code < 0)
        return av_error(code, "JPEG encoder failed");
    avcodec_send_frame(codec.get(), nullptr);
    const PacketPtr packet = make_packet();
    if (const int code = avcodec_receive_packet(codec.get(), packet.get()); code < 0)
        return av_error(code, "JPEG encoder failed");
    const auto* first = reinterpret_cast<const std::byte*>(packet->data);
    return Bytes(first, first + packet->size);
}

}  // namespace mien::media
