#include "media/ffmpeg.hpp"

#include <cstdlib>
#include <cstring>
#include <mutex>

#include "media/colour.hpp"

namespace mien::media {

std::string error_text(int code) {
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return text;
}

Error av_error(int code, std::string_view doing) {
    ErrorCode kind = ErrorCode::damaged;
    if (code == AVERROR(ENOENT) || code == AVERROR(EACCES) || code == AVERROR(ENOMEM) ||
        code == AVERROR(ENOSYS) || code == AVERROR_DECODER_NOT_FOUND || code == AVERROR_ENCODER_NOT_FOUND ||
        code == AVERROR_DEMUXER_NOT_FOUND || code == AVERROR_PATCHWELCOME)
        kind = ErrorCode::unavailable;
    return {kind, std::string(doing) + ": " + error_text(code)};
}

void quiet_libraries() {
    static std::once_flag once;
    std::call_once(once, [] {
        av_log_set_level(AV_LOG_QUIET);
        setenv("SVT_LOG", "1", 0);  // SVT-AV1 knows no other way: 1 is errors only
    });
}

AVRational to_av(Rational r) {
    return {int(r.num), int(r.den)};
}
Rational from_av(AVRational r) {
    return make_rational(r.num, r.den);
}

PacketPtr make_packet(ByteView bytes) {
    PacketPtr packet = make_packet();
    if (av_new_packet(packet.get(), int(bytes.size())) < 0) throw std::bad_alloc();
    if (!bytes.empty()) std::memcpy(packet->data, bytes.data(), bytes.size());
    return packet;
}

void set_extradata(AVCodecContext& codec, ByteView bytes) {
    if (bytes.empty()) return;
    codec.extradata =
        allocated(static_cast<std::uint8_t*>(av_mallocz(bytes.size() + AV_INPUT_BUFFER_PADDING_SIZE)));
    codec.extradata_size = int(bytes.size());
    std::memcpy(codec.extradata, bytes.data(), bytes.size());
}

Bytes extradata_of(const AVCodecContext& codec) {
    const auto* first = reinterpret_cast<const std::byte*>(codec.extradata);
    return Bytes(first, first + codec.extradata_size);
}

#if MIEN_AV_CHANNEL_LAYOUT
int channels_of(const AVCodecContext& codec) {
    return codec.ch_layout.nb_channels;
}
int channels_of(const AVFrame& frame) {
    return frame.ch_layout.nb_channels;
}
void set_channels(AVCodecContext& codec, int channels) {
    av_channel_layout_default(&codec.ch_layout, channels);
}
void set_channels(AVFrame& frame, int channels) {
    av_channel_layout_default(&frame.ch_layout, channels);
}
#else
int channels_of(const AVCodecContext& codec) {
    return codec.channels;
}
int channels_of(const AVFrame& frame) {
    return frame.channels;
}
void set_channels(AVCodecContext& codec, int channels) {
    codec.channels = channels;
    codec.channel_layout = std::uint64_t(av_get_default_channel_layout(channels));
}
void set_channels(AVFrame& frame, int channels) {
    frame.channels = channels;
    frame.channel_layout = std::uint64_t(av_get_default_channel_layout(channels));
}
#endif

bool view_of(const AVFrame& frame, YuvView& view, YuvView::Matrix matrix, bool full_range) {
    bool chroma_is_half = true;
    switch (frame.format) {
        case AV_PIX_FMT_YUV420P:
            break;
        case AV_PIX_FMT_YUVJ420P:
            full_range = true;
            break;
        case AV_PIX_FMT_YUV444P:
            chroma_is_half = false;
            break;
        case AV_PIX_FMT_YUVJ444P:
            chroma_is_half = false, full_range = true;
            break;
        default:
            return false;
    }
    switch (frame.colorspace) {
        case AVCOL_SPC_UNSPECIFIED:
            break;
        case AVCOL_SPC_BT709:
            matrix = YuvView::Matrix::bt709;
            break;
        case AVCOL_SPC_BT470BG:
        case AVCOL_SPC_SMPTE170M:
            matrix = YuvView::Matrix::bt601;
            break;
        default:
            return false;
    }
    if (frame.color_range == AVCOL_RANGE_MPEG) full_range = false;
    if (frame.color_range == AVCOL_RANGE_JPEG) full_range = true;

    view.width = frame.width;
    view.height = frame.height;
    view.chroma_width = chroma_is_half ? (frame.width + 1) / 2 : frame.width;
    view.chroma_height = chroma_is_half ? (frame.height + 1) / 2 : frame.height;
    for (int p = 0; p < 3; ++p) {
        view.planes[p] = frame.data[p];
        view.strides[p] = frame.linesize[p];
    }
    view.matrix = matrix;
    view.full_range = full_range;
    switch (frame.chroma_location) {
        case AVCHROMA_LOC_CENTER:
            view.siting = YuvView::Siting::centre;
            break;
        case AVCHROMA_LOC_TOPLEFT:
            view.siting = YuvView::Siting::top_left;
            break;
        default:
            view.siting = YuvView::Siting::left;
            break;
    }
    return true;
}

namespace {

Image interleaved(const AVFrame& gbr) {
    Image image(gbr.width, gbr.height, 3);
    for (int y = 0; y < gbr.height; ++y) {
        const auto row = [&](int p) { return gbr.data[p] + std::ptrdiff_t(y) * gbr.linesize[p]; };
        const std::uint8_t *g = row(0), *b = row(1), *r = row(2);
        std::uint8_t* to = image.at(0, y);
        for (int x = 0; x < gbr.width; ++x, to += 3) to[0] = r[x], to[1] = g[x], to[2] = b[x];
    }
    return image;
}

}  // namespace

Result<Image> rgb_of(const AVFrame& frame) {
    if (frame.format == AV_PIX_FMT_GBRP) return interleaved(frame);
    // Nobody said which matrix: broadcast practice is BT.601 for small pictures, BT.709 from 720 lines on.
    const auto matrix =
        frame.height >= 720 || frame.width >= 1280 ? YuvView::Matrix::bt709 : YuvView::Matrix::bt601;
    if (YuvView view; view_of(frame, view, matrix, false)) return to_rgb(view);

    const SwsPtr scaler(sws_alloc_context());
    if (!scaler) throw std::bad_alloc();
    const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(AVPixelFormat(frame.format));
    const bool is_rgb = format && (format->flags & AV_PIX_FMT_FLAG_RGB);
    const bool full = is_rgb || frame.color_range == AVCOL_RANGE_JPEG ||
                      frame.format == AV_PIX_FMT_YUVJ422P || frame.format == AV_PIX_FMT_YUVJ440P ||
                      frame.format == AV_PIX_FMT_YUVJ411P || frame.format == AV_PIX_FMT_GRAY8 ||
                      frame.format == AV_PIX_FMT_GRAY16;
    av_opt_set_int(scaler.get(), "srcw", frame.width, 0);
    av_opt_set_int(scaler.get(), "srch", frame.height, 0);
    av_opt_set_int(scaler.get(), "src_format", frame.format, 0);
    av_opt_set_int(scaler.get(), "src_range", full, 0);
    av_opt_set_int(scaler.get(), "dstw", frame.width, 0);
    av_opt_set_int(scaler.get(), "dsth", frame.height, 0);
    av_opt_set_int(scaler.get(), "dst_format", AV_PIX_FMT_RGB24, 0);
    av_opt_set_int(scaler.get(), "dst_range", 1, 0);
    av_opt_set_int(scaler.get(), "sws_flags",
                   SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT,
                   0);
    const int* coefficients =
        sws_getCoefficients(matrix == YuvView::Matrix::bt709 ? SWS_CS_ITU709 : SWS_CS_ITU601);
    if (frame.colorspace == AVCOL_SPC_BT709) coefficients = sws_getCoefficients(SWS_CS_ITU709);
    if (frame.colorspace == AVCOL_SPC_BT470BG || frame.colorspace == AVCOL_SPC_SMPTE170M)
        coefficients = sws_getCoefficients(SWS_CS_ITU601);
    if (frame.colorspace == AVCOL_SPC_BT2020_NCL) coefficients = sws_getCoefficients(SWS_CS_BT2020);
    sws_setColorspaceDetails(scaler.get(), coefficients, full, sws_getCoefficients(SWS_CS_ITU709), 1, 0,
                             1 << 16, 1 << 16);
    if (const int code = sws_init_context(scaler.get(), nullptr, nullptr); code < 0)
        return av_error(
            code, std::string("no way from the pixel format ") + (format ? format->name : "?") + " to RGB");

    // swscale writes whole vectors past the end of a row: it gets rows of its own.
    std::uint8_t* planes[4] = {};
    int strides[4] = {};
    if (av_image_alloc(planes, strides, frame.width, frame.height, AV_PIX_FMT_RGB24, 64) < 0)
        throw std::bad_alloc();
    const std::unique_ptr<std::uint8_t, void (*)(void*)> owner(planes[0], av_free);
    sws_scale(scaler.get(), frame.data, frame.linesize, 0, frame.height, planes, strides);
    Image image(frame.width, frame.height, 3);
    for (int y = 0; y < frame.height; ++y)
        std::memcpy(image.at(0, y), planes[0] + std::ptrdiff_t(y) * strides[0], std::size_t(frame.width) * 3);
    return image;
}

}  // namespace mien::media
