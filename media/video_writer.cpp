#include "media/video_writer.hpp"

#include <algorithm>
#include <system_error>

#include "core/environment_error.hpp"
#include "core/unfinished.hpp"
#include "media/colour.hpp"
#include "media/ffmpeg.hpp"
#include "media/sound_codec.hpp"

namespace mien::media {

struct VideoWriter::State {
    std::filesystem::path path;
    std::optional<Unfinished> unfinished;
    int width = 0, height = 0;
    OutputPtr output;
    CodecPtr codec;
    YuvImage yuv;        ///< movie only
    SoundPackets sound;  ///< movie with sound only
    std::size_t sound_written = 0;
    std::int64_t frames = 0;
    bool finished = false;

    [[noreturn]] void fail(int code) const {
        throw EnvironmentError("cannot write " + path.string() + ": " + error_text(code) +
                               "; is the folder there and writable, and is the disk not full?");
    }
    void check(int code) const {
        if (code < 0) fail(code);
    }

    void open_file(const char* format) {
        quiet_libraries();
        unfinished.emplace(path, Unfinished::Kind::file);
        const std::string part = unfinished->path().string();
        AVFormatContext* raw = nullptr;
        check(avformat_alloc_output_context2(&raw, nullptr, format, part.c_str()));
        output.reset(raw);
        output->flags |= AVFMT_FLAG_BITEXACT;
        check(avio_open(&output->pb, part.c_str(), AVIO_FLAG_WRITE));
    }

    void open_codec(const char* name, Rational frame_rate, AVDictionary** options) {
        const AVCodec* encoder = avcodec_find_encoder_by_name(name);
        if (!encoder)
            throw EnvironmentError(std::string("this FFmpeg has no ") + name + " encoder, which writing " +
                                   path.string() + " needs");
        if (!codec) codec.reset(allocated(avcodec_alloc_context3(encoder)));
        codec->time_base = to_av(frame_rate.inverse());
        codec->framerate = to_av(frame_rate);
        codec->sample_aspect_ratio = {1, 1};
        codec->thread_count = 4;
        if (output->oformat->flags & AVFMT_GLOBALHEADER) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
        check(avcodec_open2(codec.get(), encoder, options));
        AVStream* stream = allocated(avformat_new_stream(output.get(), nullptr));
        stream->time_base = codec->time_base;
        stream->avg_frame_rate = codec->framerate;
        check(avcodec_parameters_from_context(stream->codecpar, codec.get()));
    }

    void compress(const Sound& original) {
        auto packets = compress_sound(original, "aac", 160);
        if (!packets)
            throw EnvironmentError("cannot write the sound of " + path.string() + ": " +
                                   packets.error().message);
        sound = std::move(*packets);
    }

    void add_sound(const Sound& original) {
        compress(original);
        AVStream* stream = allocated(avformat_new_stream(output.get(), nullptr));
        AVCodecParameters& parameters = *stream->codecpar;
        parameters.codec_type = AVMEDIA_TYPE_AUDIO;
        parameters.codec_id = AV_CODEC_ID_AAC;
        parameters.sample_rate = sound.sample_rate;
        parameters.frame_size = sound.packet_samples;
        parameters.initial_padding = sound.preroll_packets * sound.packet_samples;
#if MIEN_AV_CHANNEL_LAYOUT
        av_channel_layout_default(&parameters.ch_layout, sound.channels);
#else
        parameters.channels = sound.channels;
        parameters.channel_layout = std::uint64_t(av_get_default_channel_layout(sound.channels));
#endif
        const std::size_t size = sound.codec_config.size();
        parameters.extradata =
            allocated(static_cast<std::uint8_t*>(av_mallocz(size + AV_INPUT_BUFFER_PADDING_SIZE)));
        parameters.extradata_size = int(size);
        std::copy_n(reinterpret_cast<const std::uint8_t*>(sound.codec_config.data()), size,
                    parameters.extradata);
        stream->time_base = {1, sound.sample_rate};
    }

    void start(const char* movflags) {
        AVDictionary* options = nullptr;
        if (movflags) av_dict_set(&options, "movflags", movflags, 0);
        const int code = avformat_write_header(output.get(), &options);
        av_dict_free(&options);
        check(code);
    }

    /// Sound up to `seconds`.
    void write_sound(double seconds) {
        for (; sound_written < sound.packets.size(); ++sound_written) {
            const std::int64_t time =
                (std::int64_t(sound_written) - sound.preroll_packets) * sound.packet_samples;
            if (double(time) > seconds * sound.sample_rate) return;
            const PacketPtr packet = make_packet(sound.packets[sound_written]);
            packet->stream_index = 1;
            packet->pts = packet->dts =
                av_rescale_q(time, {1, sound.sample_rate}, output->streams[1]->time_base);
            packet->duration =
                av_rescale_q(sound.packet_samples, {1, sound.sample_rate}, output->streams[1]->time_base);
            packet->flags |= AV_PKT_FLAG_KEY;
            check(av_interleaved_write_frame(output.get(), packet.get()));
        }
    }

    void encode(const AVFrame* frame) {
        check(avcodec_send_frame(codec.get(), frame));
        const PacketPtr packet = make_packet();
        for (;;) {
            const int code = avcodec_receive_packet(codec.get(), packet.get());
            if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
            check(code);
            packet->stream_index = 0;
            packet->duration = 1;
            av_packet_rescale_ts(packet.get(), codec->time_base, output->streams[0]->time_base);
            check(av_interleaved_write_frame(output.get(), packet.get()));
        }
    }
};

VideoWriter::VideoWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;
VideoWriter::~VideoWriter() = default;

VideoWriter VideoWriter::movie(const std::filesystem::path& path, int width, int height, Rational frame_rate,
                               Movie movie) {
    auto state = std::make_unique<State>();
    state->path = path;
    state->width = width;
    state->height = height;
    state->yuv = YuvImage(width + (width & 1), height + (height & 1), Chroma::quarter);
    state->open_file("mp4");
    const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
    state->codec.reset(allocated(avcodec_alloc_context3(encoder)));
    AVCodecContext& codec = *state->codec;
    codec.width = state->yuv.width;
    codec.height = state->yuv.height;
    codec.pix_fmt = AV_PIX_FMT_YUV420P;
    codec.color_range = AVCOL_RANGE_MPEG;
    codec.colorspace = AVCOL_SPC_BT709;
    codec.color_primaries = AVCOL_PRI_BT709;
    codec.color_trc = AVCOL_TRC_BT709;  // what players expect of a movie
    codec.chroma_sample_location = AVCHROMA_LOC_LEFT;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "preset", movie.speed.c_str(), 0);
    av_dict_set(&options, "crf", std::to_string(movie.crf).c_str(), 0);
    state->open_codec("libx264", frame_rate, &options);
    av_dict_free(&options);
    if (movie.sound && movie.sound_later) {
        state->add_sound({movie.sound->sample_rate, movie.sound->channels, {}});
        state->sound.packets.clear();
    } else if (movie.sound && !movie.sound->samples.empty()) {
        state->add_sound(*movie.sound);
    }
    state->start("+faststart");
    return VideoWriter(std::move(state));
}

VideoWriter VideoWriter::lossless(const std::filesystem::path& path, int width, int height,
                                  Rational frame_rate) {
    auto state = std::make_unique<State>();
    state->path = path;
    state->width = width;
    state->height = height;
    state->open_file("matroska");
    const AVCodec* encoder = avcodec_find_encoder_by_name("libx264rgb");
    state->codec.reset(allocated(avcodec_alloc_context3(encoder)));
    AVCodecContext& codec = *state->codec;
    codec.width = width;
    codec.height = height;
    codec.pix_fmt = AV_PIX_FMT_RGB24;
    codec.color_range = AVCOL_RANGE_JPEG;
    codec.colorspace = AVCOL_SPC_RGB;
    codec.gop_size = 30;  // what a jump to any picture decodes at most
    AVDictionary* options = nullptr;
    av_dict_set(&options, "preset", "ultrafast", 0);
    av_dict_set(&options, "qp", "0", 0);
    state->open_codec("libx264rgb", frame_rate, &options);
    av_dict_free(&options);
    state->start(nullptr);
    return VideoWriter(std::move(state));
}

void VideoWriter::write(const Image& picture) {
    State& state = *state_;
    assert(picture.width == state.width && picture.height == state.height && !state.finished);
    const FramePtr frame = make_frame();
    frame->format = state.codec->pix_fmt;
    frame->width = state.codec->width;
    frame->height = state.codec->height;
    if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
    if (state.codec->pix_fmt == AV_PIX_FMT_RGB24) {
        const int step = picture.channels, g = step >= 3 ? 1 : 0, b = step >= 3 ? 2 : 0;
        for (int y = 0; y < picture.height; ++y) {
            const std::uint8_t* from = picture.at(0, y);
            std::uint8_t* to = frame->data[0] + std::ptrdiff_t(y) * frame->linesize[0];
            for (int x = 0; x < picture.width; ++x, from += step, to += 3)
                to[0] = from[0], to[1] = from[g], to[2] = from[b];
        }
    } else {
        to_yuv(picture, state.yuv);
        for (int p = 0; p < 3; ++p) {
            const int w = p ? state.yuv.chroma_width : state.yuv.width,
                      h = p ? state.yuv.chroma_height : state.yuv.height;
            av_image_copy_plane(frame->data[p], frame->linesize[p], state.yuv.planes[p].data(), w, w, h);
        }
    }
    frame->pts = state.frames++;
    state.encode(frame.get());
    state.write_sound(double(state.frames) * av_q2d(state.codec->time_base));
}

void VideoWriter::set_sound(const Sound& sound) {
    assert(state_->output->nb_streams == 2 && state_->sound.packets.empty() && sound.channels == state_->sound.channels);
    state_->compress(sound);
}

void VideoWriter::finish() {
    State& state = *state_;
    assert(!state.finished);
    state.encode(nullptr);
    state.write_sound(1e12);
    state.check(av_write_trailer(state.output.get()));
    state.check(avio_closep(&state.output->pb));
    if (const std::error_code error = state.unfinished->finish(true)) cannot_write(state.path, error.value());
    state.finished = true;
}

}  // namespace mien::media
