#include "media/video_decoder.hpp"

#include "media/ffmpeg.hpp"

namespace mien::media {
namespace {

const AVCodec* find_decoder(const std::string& name) {
    std::vector<const char*> names;
    if (name == "mpeg4") names = {"mpeg4"};
    if (name == "h264") names = {"h264"};
    if (name == "hevc") names = {"hevc"};
    if (name == "av1") names = {"libdav1d", "libaom-av1"};  // FFmpeg's own needs a GPU
    for (const char* decoder : names)
        if (const AVCodec* found = avcodec_find_decoder_by_name(decoder)) return found;
    return nullptr;
}

}  // namespace

struct VideoDecoder::State {
    const AVCodec* decoder;
    std::string name;
    Bytes config;
    int width, height;
    YuvView::Matrix matrix;
    bool full_range;
    int threads;
    CodecPtr codec;      ///< none: opened when the next packet comes
    bool used = false;   ///< a packet has been fed to it

    Result<void> open() {
        codec.reset(allocated(avcodec_alloc_context3(decoder)));
        set_extradata(*codec, config);
        codec->width = width;
        codec->height = height;
        // Codecs round sizes up to their largest block and add a border before they ask for memory.
        codec->max_pixels = (std::int64_t(width) + 256) * (height + 512);
        codec->err_recognition = AV_EF_EXPLODE | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_CRCCHECK;
        codec->error_concealment = 0;
        codec->idct_algo = FF_IDCT_SIMPLE;
        codec->thread_count = threads > 0 ? threads : 2;
        codec->thread_type = threads > 0 ? FF_THREAD_FRAME | FF_THREAD_SLICE : FF_THREAD_SLICE;
        AVDictionary* options = nullptr;
        if (threads <= 0 && std::string_view(decoder->name) == "libdav1d") {
            // One picture at a time: its rows and tiles on two threads, no picture of delay. Later releases took
            // both names for max_frame_delay.
            av_dict_set(&options, "framethreads", "1", 0);
            av_dict_set(&options, "tilethreads", "2", 0);
            av_dict_set(&options, "max_frame_delay", "1", 0);
        }
        const int code = avcodec_open2(codec.get(), decoder, &options);
        av_dict_free(&options);
        used = false;
        if (code >= 0) return {};
        codec.reset();
        return av_error(code, "the " + name + " decoder refuses the codec headers");
    }

    Result<std::vector<VideoPicture>> receive() {
        std::vector<VideoPicture> pictures;
        for (;;) {
            FramePtr frame = make_frame();
            const int code = avcodec_receive_frame(codec.get(), frame.get());
            if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return pictures;
            if (code < 0) return av_error(code, name + " picture does not decode");
            if (frame->decode_error_flags || (frame->flags & AV_FRAME_FLAG_CORRUPT))
                return Error{ErrorCode::damaged, name + " picture is damaged"};
            if (frame->width != width || frame->height != height)
                return Error{ErrorCode::mismatch, name + " picture is " + std::to_string(frame->width) +
                                                      " x " + std::to_string(frame->height) + " where " +
                                                      std::to_string(width) + " x " + std::to_string(height) +
                                                      " was announced"};
            VideoPicture picture;
            if (!view_of(*frame, picture.picture, matrix, full_range))
                return Error{ErrorCode::invalid,
                             name +
                                 " picture has a pixel format or colour matrix other than 8-bit "
                                 "4:2:0 or 4:4:4 in BT.709 or BT.601"};
            picture.owner = std::shared_ptr<AVFrame>(frame.release(), [](AVFrame* p) { av_frame_free(&p); });
            pictures.push_back(std::move(picture));
        }
    }
};

VideoDecoder::VideoDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoDecoder::VideoDecoder(VideoDecoder&&) noexcept = default;
VideoDecoder& VideoDecoder::operator=(VideoDecoder&&) noexcept = default;
VideoDecoder::~VideoDecoder() = default;

Result<VideoDecoder> VideoDecoder::open(const VideoDecoderSettings& s) {
    quiet_libraries();
    const AVCodec* decoder = find_decoder(s.codec);
    if (!decoder)
        return Error{ErrorCode::unavailable,
                     "there is no decoder for the texture codec '" + s.codec + "' here"};
    auto state = std::make_unique<State>(State{.decoder = decoder,
                                               .name = s.codec,
                                               .config = Bytes(s.codec_config.begin(), s.codec_config.end()),
                                               .width = s.width,
                                               .height = s.height,
                                               .matrix = s.matrix,
                                               .full_range = s.full_range,
                                               .threads = s.threads,
                                               .codec = nullptr});
    MIEN_CHECK(state->open());
    return VideoDecoder(std::move(state));
}

void VideoDecoder::restart() {
    // Flushing is not enough: what a damaged packet told the decoder, a size or a whole header, would stay with it.
    if (state_->used) state_->codec.reset();
}

Result<std::vector<VideoPicture>> VideoDecoder::decode(ByteView bytes) {
    if (bytes.empty()) return Error{ErrorCode::damaged, state_->name + " packet is empty"};
    if (!state_->codec) MIEN_CHECK(state_->open());
    state_->used = true;
    const PacketPtr packet = make_packet(bytes);
    if (const int code = avcodec_send_packet(state_->codec.get(), packet.get()); code < 0)
        return av_error(code, state_->name + " packet does not decode");
    return state_->receive();
}

Result<std::vector<VideoPicture>> VideoDecoder::drain() {
    if (!state_->codec) return std::vector<VideoPicture>();
    state_->used = true;
    if (const int code = avcodec_send_packet(state_->codec.get(), nullptr); code < 0)
        return av_error(code, state_->name + " decoder failed");
    return state_->receive();
}

}  // namespace mien::media
