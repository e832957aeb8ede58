#include "media/video_reader.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "core/parallel.hpp"
#include "media/ffmpeg.hpp"

namespace mien::media {
namespace {

/// What one packet of the stream shows, in decoding order.
struct Entry {
    std::int64_t pts = AV_NOPTS_VALUE;
    std::int64_t dts = AV_NOPTS_VALUE;
    bool key = false;
};

struct OpenVideo {
    InputPtr input;
    CodecPtr codec;
    int stream = -1;
};

Result<OpenVideo> open_video(const std::string& path) {
    quiet_libraries();
    AVFormatContext* raw = nullptr;
    if (const int code = avformat_open_input(&raw, path.c_str(), nullptr, nullptr); code < 0) {
        Error error = av_error(code, "cannot read " + path);
        if (code != AVERROR_INVALIDDATA) error.code = ErrorCode::unavailable;
        return error;
    }
    OpenVideo video{InputPtr(raw), nullptr, -1};
    if (const int code = avformat_find_stream_info(raw, nullptr); code < 0)
        return av_error(code, "cannot read " + path);
    video.stream = av_find_best_stream(raw, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (video.stream < 0) return Error{ErrorCode::missing, path + " has no video"};
    for (unsigned s = 0; s < raw->nb_streams; ++s)
        if (int(s) != video.stream) raw->streams[s]->discard = AVDISCARD_ALL;
    const AVCodecParameters& parameters = *raw->streams[video.stream]->codecpar;
    // FFmpeg's own AV1 decoder needs a GPU.
    const AVCodec* decoder =
        parameters.codec_id == AV_CODEC_ID_AV1 ? avcodec_find_decoder_by_name("libdav1d") : nullptr;
    if (!decoder) decoder = avcodec_find_decoder(parameters.codec_id);
    if (!decoder)
        return Error{ErrorCode::unavailable,
                     path + ": this FFmpeg has no decoder for " + avcodec_get_name(parameters.codec_id)};
    video.codec.reset(allocated(avcodec_alloc_context3(decoder)));
    if (const int code = avcodec_parameters_to_context(video.codec.get(), &parameters); code < 0)
        return av_error(code, "cannot read " + path);
    video.codec->pkt_timebase = raw->streams[video.stream]->time_base;
    video.codec->max_pixels = 8192 * 8192;
    video.codec->thread_count = std::min(thread_count(), 8);
    if (const int code = avcodec_open2(video.codec.get(), decoder, nullptr); code < 0)
        return av_error(code, "cannot decode " + path);
    return video;
}

}  // namespace

struct VideoReader::State {
    std::string path;
    OpenVideo video;
    std::vector<Entry> entries;      ///< in decoding order
    std::vector<std::size_t> shown;  ///< presentation order -> entry
    bool seekable = false;           ///< every packet has a presentation time of its own
    std::int64_t next = 0;  ///< number of the frame that the decoder gives next; -1: to be found by its time
    bool draining = false;
    std::int64_t last_number = -1;  ///< of the frame below
    FramePtr frame = make_frame();
    PacketPtr packet = make_packet();

    std::int64_t pts_of(std::int64_t number) const { return entries[shown[std::size_t(number)]].pts; }

    /// Counts the packets, without decoding them.
    Result<void> scan() {
        seekable = true;
        for (;;) {
            const int code = av_read_frame(video.input.get(), packet.get());
            if (code == AVERROR_EOF) break;
            if (code < 0) break;  // a cut file plays to where it is cut
            if (packet->stream_index == video.stream && !(packet->flags & AV_PKT_FLAG_DISCARD)) {
                entries.push_back({packet->pts, packet->dts, (packet->flags & AV_PKT_FLAG_KEY) != 0});
                if (packet->pts == AV_NOPTS_VALUE) seekable = false;
            }
            av_packet_unref(packet.get());
        }
        shown.resize(entries.size());
        for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = i;
        if (seekable) {
            std::stable_sort(shown.begin(), shown.end(),
                             [&](std::size_t a, std::size_t b) { return entries[a].pts < entries[b].pts; });
            for (std::size_t i = 1; i < shown.size(); ++i)
                seekable = seekable && entries[shown[i]].pts != entries[shown[i - 1]].pts;
        }
        return reopen();
    }

    Result<void> reopen() {
        MIEN_TRY(again, open_video(path));
        video = std::move(again);
        next = 0;
        draining = false;
        last_number = -1;
        return {};
    }

    /// Decodes the next picture into `frame`; false at the end.
    Result<bool> decode_next() {
        for (;;) {
            const int code = avcodec_receive_frame(video.codec.get(), frame.get());
            if (code == 0) return true;
            if (code == AVERROR_EOF) return false;
            if (code != AVERROR(EAGAIN)) return av_error(code, path + " does not decode");
            if (draining) return false;
            int read = av_read_frame(video.input.get(), packet.get());
            if (read < 0) {
                draining = true;
                read = avcodec_send_packet(video.codec.get(), nullptr);
            } else {
                read = packet->stream_index == video.stream
                           ? avcodec_send_packet(video.codec.get(), packet.get())
                           : 0;
                av_packet_unref(packet.get());
            }
            if (read < 0 && read != AVERROR_EOF) return av_error(read, path + " does not decode");
        }
    }

    std::int64_t number_of_frame() const {
        const std::int64_t pts = frame->best_effort_timestamp;
        const auto at =
            std::lower_bound(shown.begin(), shown.end(), pts,
                             [&](std::size_t entry, std::int64_t t) { return entries[entry].pts < t; });
        if (at == shown.end() || entries[*at].pts != pts) return -1;
        return at - shown.begin();
    }

    /// Puts the decoder before `number`: at the last key frame from which it decodes. `back`: that many key
    /// frames earlier.
    Result<void> seek(std::int64_t number, int back) {
        std::size_t entry = shown[std::size_t(number)];
        for (;; --entry) {
            if (entries[entry].key && entries[entry].pts <= pts_of(number) && back-- == 0) break;
            if (entry == 0) return reopen();
        }
        const std::int64_t time = entries[entry].dts != AV_NOPTS_VALUE
                                      ? std::min(entries[entry].dts, entries[entry].pts)
                                      : entries[entry].pts;
        if (av_seek_frame(video.input.get(), video.stream, time, AVSEEK_FLAG_BACKWARD) < 0) return reopen();
        avcodec_flush_buffers(video.codec.get());
        next = -1;
        draining = false;
        last_number = -1;
        return {};
    }

    /// Whether it is better to seek than to decode on to `number`.
    bool worth_seeking(std::int64_t number) const {
        if (next < 0 || number < next) return true;
        for (std::size_t entry = shown[std::size_t(number)]; entry > shown[std::size_t(next)]; --entry)
            if (entries[entry].key && entries[entry].pts <= pts_of(number)) return true;
        return false;
    }

    /// Leaves frame `number` in `frame`.
    Result<void> find(std::int64_t number) {
        if (number == last_number) return {};
        if (!seekable) {
            if (number < next) MIEN_CHECK(reopen());
        } else if (worth_seeking(number)) {
            MIEN_CHECK(seek(number, 0));
        }
        for (int attempt = 1;;) {
            MIEN_TRY(more, decode_next());
            std::int64_t here = next;
            if (more && seekable) {
                here = number_of_frame();
                if (here < 0) continue;  // not counted: cut away by an edit list
            }
            if (more && here == number) {
                next = number + 1;
                last_number = number;
                return {};
            }
            if (more && here < number) {
                next = here + 1;
                continue;
            }
            // Past it, or at the end: the key frame did not do. Go further back, in the end to the very
            // beginning.
            if (!seekable || attempt > 3)
                return Error{ErrorCode::damaged, path + ": frame " + std::to_string(number) + " of " +
                                                     std::to_string(shown.size()) + " does not decode"};
            if (attempt < 3)
                MIEN_CHECK(seek(number, attempt));
            else
                MIEN_CHECK(reopen());
            ++attempt;
        }
    }
};

VideoReader::VideoReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoReader::~VideoReader() = default;

Result<std::unique_ptr<VideoReader>> VideoReader::open(const std::filesystem::path& path) {
    auto state = std::make_unique<State>();
    state->path = path.string();
    MIEN_TRY(video, open_video(state->path));
    state->video = std::move(video);
    MIEN_CHECK(state->scan());
    if (state->entries.empty()) return Error{ErrorCode::damaged, state->path + " has no video frames"};
    MIEN_CHECK(state->find(0));
    if (!state->seekable) {
        // Nothing tells frames from packets but decoding them all.
        std::size_t count = 1;
        for (;; ++count) {
            MIEN_TRY(more, state->decode_next());
            if (!more) break;
        }
        state->shown.resize(count);
        MIEN_CHECK(state->reopen());
        MIEN_CHECK(state->find(0));
    }
    return std::unique_ptr<VideoReader>(new VideoReader(std::move(state)));
}

int VideoReader::width() const {
    return state_->video.codec->width;
}
int VideoReader::height() const {
    return state_->video.codec->height;
}
std::int64_t VideoReader::frames() const {
    return std::int64_t(state_->shown.size());
}

Rational VideoReader::frame_rate() const {
    AVStream* stream = state_->video.input->streams[state_->video.stream];
    const AVRational rate = av_guess_frame_rate(state_->video.input.get(), stream, nullptr);
    return rate.num > 0 && rate.den > 0 ? from_av(rate) : Rational{0, 1};
}

Result<Image> VideoReader::read(std::int64_t number) {
    assert(number >= 0 && number < frames());
    MIEN_CHECK(state_->find(number));
    return rgb_of(*state_->frame);
}

}  // namespace mien::media
