#include "media/picture.hpp"

#include "media/ffmpeg.hpp"

namespace mien::media {

Result<Image> decode_picture(ByteView bytes) {
    quiet_libraries();
    const auto byte = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
    AVCodecID id = AV_CODEC_ID_NONE;
    if (bytes.size() >= 3 && byte(0) == 0xff && byte(1) == 0xd8 && byte(2) == 0xff) id = AV_CODEC_ID_MJPEG;
    if (bytes.size() >= 8 && byte(0) == 0x89 && byte(1) == 'P' && byte(2) == 'N' && byte(3) == 'G')
        id = AV_CODEC_ID_PNG;
    if (id == AV_CODEC_ID_NONE) return Error{ErrorCode::bad_magic, "picture is neither JPEG nor PNG"};
    const AVCodec* decoder = avcodec_find_decoder(id);
    if (!decoder) return Error{ErrorCode::unavailable, "this FFmpeg decodes no JPEG or PNG"};
    const CodecPtr codec(allocated(avcodec_alloc_context3(decoder)));
    codec->max_pixels = most_pixels(bytes);
    codec->thread_count = 1;
    codec->err_recognition = AV_EF_EXPLODE;
    if (const int code = avcodec_open2(codec.get(), decoder, nullptr); code < 0)
        return av_error(code, "picture decoder failed");
    const PacketPtr packet = make_packet(bytes);
    if (const int code = avcodec_send_packet(codec.get(), packet.get()); code < 0)
        return av_error(code, "picture does not decode");
    avcodec_send_packet(codec.get(), nullptr);
    const FramePtr frame = make_frame();
    if (const int code = avcodec_receive_frame(codec.get(), frame.get()); code < 0)
        return av_error(code, "picture does not decode");
    if (id == AV_CODEC_ID_MJPEG) {
        // JFIF: full range BT.601, chroma in the middle of its block.
        frame->color_range = AVCOL_RANGE_JPEG;
        if (frame->colorspace == AVCOL_SPC_UNSPECIFIED) frame->colorspace = AVCOL_SPC_SMPTE170M;
        frame->chroma_location = AVCHROMA_LOC_CENTER;
    }
    return rgb_of(*frame);
}

}  // namespace mien::media
