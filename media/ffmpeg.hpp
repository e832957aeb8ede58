#pragma once

/// Owning handles and small helpers over FFmpeg's C libraries (4.4 to 7). Only sources of this room include
/// it: no FFmpeg type appears in any other header.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/channel_layout.h>
#include <libavutil/cpu.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswresample/swresample.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <memory>
#include <new>
#include <string>

#include "core/hash.hpp"
#include "core/image.hpp"
#include "core/result.hpp"

// AVChannelLayout came with FFmpeg 5.1; the fields it replaced are gone since 7.
#define MIEN_AV_CHANNEL_LAYOUT (LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(57, 28, 100))

namespace mien::media {

template <auto release>
struct Release {
    template <class T>
    void operator()(T* p) const {
        release(&p);
    }
};
struct ReleaseSws {
    void operator()(SwsContext* p) const { sws_freeContext(p); }
};
struct ReleaseOutput {
    void operator()(AVFormatContext* p) const {
        if (p && p->pb) avio_closep(&p->pb);
        avformat_free_context(p);
    }
};

using FramePtr = std::unique_ptr<AVFrame, Release<av_frame_free>>;
using PacketPtr = std::unique_ptr<AVPacket, Release<av_packet_free>>;
using CodecPtr = std::unique_ptr<AVCodecContext, Release<avcodec_free_context>>;
using InputPtr = std::unique_ptr<AVFormatContext, Release<avformat_close_input>>;
using OutputPtr = std::unique_ptr<AVFormatContext, ReleaseOutput>;
using SwsPtr = std::unique_ptr<SwsContext, ReleaseSws>;
using SwrPtr = std::unique_ptr<SwrContext, Release<swr_free>>;

template <class T>
T* allocated(T* p) {
    if (!p) throw std::bad_alloc();
    return p;
}
inline FramePtr make_frame() {
    return FramePtr(allocated(av_frame_alloc()));
}
inline PacketPtr make_packet() {
    return PacketPtr(allocated(av_packet_alloc()));
}

/// What FFmpeg's error code says in words.
std::string error_text(int code);
/// An Error of ours from FFmpeg's code: bad bytes are `damaged`, what is not built in or cannot be opened
/// `unavailable`.
Error av_error(int code, std::string_view doing);

/// FFmpeg's own messages go nowhere (ours say what is wrong); call before the first use of a codec.
void quiet_libraries();

inline constexpr int kMaxPictureSide = 8192;
/// How many pixels a picture file of these bytes may claim before room is made for them. The densest that codecs write, an even
/// picture by DCT and deflate (OpenEXR's DWAB) or a PNG of one bit a pixel, comes near 10 000 a byte.
inline std::int64_t most_pixels(ByteView bytes) {
    return std::min<std::int64_t>(std::int64_t(kMaxPictureSide) * kMaxPictureSide, 10'000 * std::int64_t(bytes.size()));
}

AVRational to_av(Rational r);
Rational from_av(AVRational r);

/// A packet with a copy of `bytes` and the zero padding that FFmpeg's parsers read past the end.
PacketPtr make_packet(ByteView bytes);
/// Copies `bytes` to where a codec looks for its out-of-band headers.
void set_extradata(AVCodecContext& codec, ByteView bytes);
Bytes extradata_of(const AVCodecContext& codec);

int channels_of(const AVCodecContext& codec);
int channels_of(const AVFrame& frame);
void set_channels(AVCodecContext& codec, int channels);
void set_channels(AVFrame& frame, int channels);

/// The planes of a decoded 8-bit 4:2:0 or 4:4:4 picture; matrix and range from its own flags, else from the
/// arguments. False for any other pixel format or matrix.
bool view_of(const AVFrame& frame, YuvView& view, YuvView::Matrix matrix, bool full_range);
/// RGB of any picture FFmpeg decodes.
Result<Image> rgb_of(const AVFrame& frame);

}  // namespace mien::media
