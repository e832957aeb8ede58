#include "media/lossless_video.hpp"

#include <algorithm>
#include <cassert>

#include "core/parallel.hpp"
#include "media/ffmpeg.hpp"

namespace mien::media {

struct LosslessVideoWriter::State {
    std::string path;
    CodecPtr codec;
    OutputPtr file;
    AVStream* stream = nullptr;
    FramePtr frame = make_frame();
    PacketPtr packet = make_packet();
    std::int64_t next = 0;

    Result<void> send(const AVFrame* picture) {
        if (const int code = avcodec_send_frame(codec.get(), picture); code < 0)
            return av_error(code, "cannot encode " + path);
        for (;;) {
            const int code = avcodec_receive_packet(codec.get(), packet.get());
            if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
            if (code < 0) return av_error(code, "cannot encode " + path);
            packet->duration = 1;
            packet->stream_index = stream->index;
            av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
            if (const int written = av_interleaved_write_frame(file.get(), packet.get()); written < 0)
                return av_error(written, "cannot write " + path);
        }
    }
};

LosslessVideoWriter::LosslessVideoWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
LosslessVideoWriter::LosslessVideoWriter(LosslessVideoWriter&&) noexcept = default;
LosslessVideoWriter& LosslessVideoWriter::operator=(LosslessVideoWriter&&) noexcept = default;
LosslessVideoWriter::~LosslessVideoWriter() = default;

Result<LosslessVideoWriter> LosslessVideoWriter::open(const std::filesystem::path& path, int width,
                                                      int height, Rational frame_rate) {
    quiet_libraries();
    auto state = std::make_unique<State>();
    state->path = path.string();
    const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_FFV1);
    if (!encoder) return Error{ErrorCode::unavailable, "this FFmpeg has no FFV1 encoder"};
    state->codec.reset(allocated(avcodec_alloc_context3(encoder)));
    AVCodecContext& codec = *state->codec;
    codec.width = width;
    codec.height = height;
    codec.pix_fmt = AV_PIX_FMT_0RGB32;
    codec.time_base = to_av(frame_rate.inverse());
    codec.framerate = to_av(frame_rate);
    codec.level = 3;
    codec.gop_size = 1;
    codec.slices = width >= 64 && height >= 64 ? 4 : 1;  // not of the thread count: the bytes depend on it
    codec.thread_count = std::min(thread_count(), 4);
    codec.thread_type = FF_THREAD_SLICE;
    av_opt_set_int(codec.priv_data, "slicecrc", 1, 0);

    AVFormatContext* raw = nullptr;
    if (const int code = avformat_alloc_output_context2(&raw, nullptr, "matroska", state->path.c_str());
        code < 0)
        return av_error(code, "cannot write " + state->path);
    state->file.reset(raw);
    raw->flags |= AVFMT_FLAG_BITEXACT;
    codec.flags |= AV_CODEC_FLAG_BITEXACT;
    if (raw->oformat->flags & AVFMT_GLOBALHEADER) codec.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (const int code = avcodec_open2(&codec, encoder, nullptr); code < 0)
        return av_error(code, "cannot encode " + state->path);
    state->stream = allocated(avformat_new_stream(raw, nullptr));
    state->stream->time_base = codec.time_base;
    state->stream->avg_frame_rate = codec.framerate;
    if (const int code = avcodec_parameters_from_context(state->stream->codecpar, &codec); code < 0)
        return av_error(code, "cannot write " + state->path);
    if (const int code = avio_open(&raw->pb, state->path.c_str(), AVIO_FLAG_WRITE); code < 0) {
        Error error = av_error(code, "cannot write " + state->path);
        error.code = ErrorCode::unavailable;
        return error;
    }
    if (const int code = avformat_write_header(raw, nullptr); code < 0)
        return av_error(code, "cannot write " + state->path);
    state->frame->format = codec.pix_fmt;
    state->frame->width = width;
    state->frame->height = height;
    if (const int code = av_frame_get_buffer(state->frame.get(), 0); code < 0)
        return av_error(code, "cannot encode " + state->path);
    return LosslessVideoWriter(std::move(state));
}

Result<void> LosslessVideoWriter::write(const Image& picture) {
    AVFrame& frame = *state_->frame;
    assert(picture.channels == 3 && picture.width == frame.width && picture.height == frame.height);
    if (const int code = av_frame_make_writable(&frame); code < 0)
        return av_error(code, "cannot encode " + state_->path);
    for (int y = 0; y < picture.height; ++y) {
        auto* row = reinterpret_cast<std::uint32_t*>(frame.data[0] + std::ptrdiff_t(y) * frame.linesize[0]);
        const std::uint8_t* from = picture.at(0, y);
        for (int x = 0; x < picture.width; ++x, from += 3)
            row[x] = 0xff000000u | std::uint32_t(from[0]) << 16 | std::uint32_t(from[1]) << 8 | from[2];
    }
    frame.pts = state_->next++;
    return state_->send(&frame);
}

Result<void> LosslessVideoWriter::finish() {
    if (auto drained = state_->send(nullptr); !drained.ok()) return drained;
    if (const int code = av_write_trailer(state_->file.get()); code < 0)
        return av_error(code, "cannot write " + state_->path);
    if (const int code = avio_closep(&state_->file->pb); code < 0)
        return av_error(code, "cannot write " + state_->path);
    return {};
}

}  // namespace mien::media
