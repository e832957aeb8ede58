#include "media/video_encoder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>

#include "media/ffmpeg.hpp"

namespace mien::media {
namespace {

using Options = std::map<std::string, std::string>;

struct Codec {
    const char* name;
    std::vector<const char*> encoders;  // the first one that is there counts
};
const std::vector<Codec>& codecs() {
    static const std::vector<Codec> all{{"mpeg4", {"mpeg4"}},
                                        {"h264", {"libx264"}},
                                        {"hevc", {"libx265"}},
                                        {"av1", {"libsvtav1", "libaom-av1"}}};
    return all;
}
const AVCodec* find_encoder(const std::string& name) {
    for (const Codec& codec : codecs())
        if (codec.name == name)
            for (const char* encoder : codec.encoders)
                if (const AVCodec* found = avcodec_find_encoder_by_name(encoder)) return found;
    return nullptr;
}

constexpr int kQpRange = 51;  // FFmpeg's wrappers multiply a region's offset by it

double between(double low, double high, double quality) {
    return low + (high - low) * std::clamp(quality, 0.0, VideoEncoderSettings::kFinestQuality) / 100;
}

void tune_mpeg4(const VideoEncoderSettings& s, AVCodecContext& codec, Options& options) {
    codec.thread_count = 1;  // threads would cut the picture into slices
    codec.flags |= AV_CODEC_FLAG_BITEXACT | AV_CODEC_FLAG_4MV;
    codec.flags &= ~AV_CODEC_FLAG_INTERLACED_DCT;
    codec.idct_algo = FF_IDCT_SIMPLE;  // the decoder takes the same one: no drift
    codec.mb_decision = s.speed == "fast" ? FF_MB_DECISION_SIMPLE : FF_MB_DECISION_RD;
    codec.trellis = 1;
    codec.max_b_frames = 2;
    codec.qmin = 1;
    if (!s.kbps) {
        codec.flags |= AV_CODEC_FLAG_QSCALE;
        codec.global_quality =
            int(std::lround(FF_QP2LAMBDA * 31 * std::pow(2.0 / 31, std::min(between(0, 1, s.quality), 1.0))));
    } else {
        codec.bit_rate_tolerance = int(std::min<std::int64_t>(codec.bit_rate * 4, INT32_MAX));
    }
    options["motion_est"] = "epzs";
    options["sc_threshold"] = "1000000000";  // closed groups know no scene changes of their own
}

void tune_x264(const VideoEncoderSettings& s, AVCodecContext& codec, Options& options) {
    codec.thread_count = 4;
    options["preset"] = s.speed.empty() ? "medium" : s.speed;
    options["forced-idr"] = "1";
    options["sc_threshold"] = "0";  // key frames fall where groups start and nowhere else
    options["x264-params"] = "open-gop=0";
    // x264 164's macroblock tree reads what nobody wrote in its AVX-512 form, unless the width is a multiple of 128.
    if (av_get_cpu_flags() & AV_CPU_FLAG_AVX512) options["x264-params"] += ":asm=AVX2";
    if (!s.regions.empty()) {
        // Regions say what is seen; the encoder's own idea of it, flat areas first, gets half its say. A key frame that is much
        // finer than the frame before it shows as a pulse, once a group.
        options["aq-strength"] = "0.5";
        options["x264-params"] += ":ipratio=1.1";
    }
    if (!s.kbps) options["crf"] = std::to_string(between(46, 12, s.quality));
}

void tune_x265(const VideoEncoderSettings& s, AVCodecContext&, Options& options) {
    options["preset"] = s.speed.empty() ? "fast" : s.speed;
    options["forced-idr"] = "1";
    // Pictures side by side would make the rate control depend on which is done first.
    options["x265-params"] = "open-gop=0:scenecut=0:info=0:log-level=none:frame-threads=1:pools=4:keyint=" +
                             std::to_string(s.key_interval) + ":min-keyint=1";
    if (!s.regions.empty()) options["x265-params"] += ":ipratio=1.1";  // as with x264: a key frame is not to pulse
    if (!s.kbps) options["crf"] = std::to_string(between(46, 12, s.quality));
}

void tune_svt_av1(const VideoEncoderSettings& s, AVCodecContext&, Options& options) {
    options["preset"] = s.speed.empty() ? "8" : s.speed;
    // Its rate control takes what is done by then, unless one thread does all; at a fixed quality threads change nothing.
    options["svtav1-params"] = s.kbps ? "scd=0:lp=1" : "scd=0";
    if (!s.kbps) options["crf"] = std::to_string(std::max(1L, std::lround(between(63, 12, s.quality))));
}

void tune_aom_av1(const VideoEncoderSettings& s, AVCodecContext& codec, Options& options) {
    codec.thread_count = 4;
    options["cpu-used"] = s.speed.empty() ? "6" : s.speed;
    options["row-mt"] = "1";
    options["usage"] = "good";
    if (!s.kbps) options["crf"] = std::to_string(std::max(1L, std::lround(between(63, 12, s.quality))));
}

/// Cuts supplemental messages (the encoder's own advertisement, mostly) out of an Annex B byte stream.
Bytes without_sei(ByteView stream, bool hevc) {
    const auto byte = [&](std::size_t i) { return std::to_integer<unsigned>(stream[i]); };
    const auto start_code = [&](std::size_t i) {
        return byte(i) == 0 && byte(i + 1) == 0 && byte(i + 2) == 1;
    };
    Bytes kept;
    std::size_t unit = 0;  // the unit's first byte, its start code and leading zero included
    for (std::size_t i = 0; i + 3 < stream.size();) {
        if (!start_code(i)) {
            ++i;
            continue;
        }
        std::size_t next = i + 3;
        while (next + 3 < stream.size() && !start_code(next)) ++next;
        if (next + 3 >= stream.size()) {
            next = stream.size();
        } else if (byte(next - 1) == 0) {
            --next;  // a start code of four bytes
        }
        const unsigned type = hevc ? byte(i + 3) >> 1 & 63 : byte(i + 3) & 31;
        if (hevc ? type != 39 && type != 40 : type != 6)
            kept.insert(kept.end(), stream.begin() + std::ptrdiff_t(unit),
                        stream.begin() + std::ptrdiff_t(next));
        unit = i = next;
    }
    return kept;
}

}  // namespace

struct VideoEncoder::State {
    VideoEncoderSettings settings;
    CodecPtr codec;
    Bytes config;
    std::int64_t fed = 0;
    bool annex_b = false, hevc = false;
    std::vector<AVRegionOfInterest> regions;

    Result<std::vector<VideoPacket>> receive(bool finishing) {
        std::vector<VideoPacket> packets;
        const PacketPtr packet = make_packet();
        for (;;) {
            const int code = avcodec_receive_packet(codec.get(), packet.get());
            if (code == AVERROR_EOF || (code == AVERROR(EAGAIN) && !finishing)) return packets;
            if (code < 0) return av_error(code, settings.codec + " encoder failed");
            const ByteView bytes(reinterpret_cast<const std::byte*>(packet->data), std::size_t(packet->size));
            VideoPacket out{packet->pts, (packet->flags & AV_PKT_FLAG_KEY) != 0, {}};
            out.bytes = annex_b ? without_sei(bytes, hevc) : Bytes(bytes.begin(), bytes.end());
            packets.push_back(std::move(out));
            av_packet_unref(packet.get());
        }
    }
};

VideoEncoder::VideoEncoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
VideoEncoder::VideoEncoder(VideoEncoder&&) noexcept = default;
VideoEncoder& VideoEncoder::operator=(VideoEncoder&&) noexcept = default;
VideoEncoder::~VideoEncoder() = default;

const Bytes& VideoEncoder::codec_config() const {
    return state_->config;
}

std::vector<std::string> VideoEncoder::available() {
    std::vector<std::string> names;
    for (const Codec& codec : codecs())
        if (find_encoder(codec.name)) names.push_back(codec.name);
    return names;
}

bool VideoEncoder::takes_regions(const std::string& codec) {
    const AVCodec* encoder = find_encoder(codec);
    const std::string name = encoder ? encoder->name : "";
    return name == "libx264" || name == "libx265";
}

Result<VideoEncoder> VideoEncoder::open(const VideoEncoderSettings& s) {
    assert(s.width == coded_side(s.width) && s.height == coded_side(s.height));
    quiet_libraries();
    const AVCodec* encoder = find_encoder(s.codec);
    if (!encoder) {
        std::string names;
        for (const std::string& name : available()) names += (names.empty() ? "" : ", ") + name;
        return Error{ErrorCode::unavailable,
                     "there is no texture codec '" + s.codec + "' here; available are " + names};
    }
    auto state = std::make_unique<State>();
    state->settings = s;
    state->codec.reset(allocated(avcodec_alloc_context3(encoder)));
    AVCodecContext& codec = *state->codec;
    codec.width = s.width;
    codec.height = s.height;
    codec.pix_fmt = AV_PIX_FMT_YUV420P;
    codec.time_base = to_av(s.frame_rate.inverse());
    codec.framerate = to_av(s.frame_rate);
    codec.sample_aspect_ratio = {1, 1};
    codec.color_range = s.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    codec.colorspace = AVCOL_SPC_BT709;
    codec.color_primaries = AVCOL_PRI_BT709;
    codec.color_trc = AVCOL_TRC_IEC61966_2_1;
    codec.chroma_sample_location = AVCHROMA_LOC_LEFT;
    codec.flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_CLOSED_GOP;
    codec.gop_size = int(std::clamp<std::int64_t>(s.key_interval, 1, INT32_MAX / 2));
    if (s.kbps) codec.bit_rate = std::llround(*s.kbps * 1000);

    Options options;
    const std::string name = encoder->name;
    if (name == "mpeg4") tune_mpeg4(s, codec, options);
    if (name == "libx264") tune_x264(s, codec, options);
    if (name == "libx265") tune_x265(s, codec, options);
    if (name == "libsvtav1") tune_svt_av1(s, codec, options);
    if (name == "libaom-av1") tune_aom_av1(s, codec, options);

    AVDictionary* dictionary = nullptr;
    for (const auto& [key, value] : options) av_dict_set(&dictionary, key.c_str(), value.c_str(), 0);
    const int code = avcodec_open2(&codec, encoder, &dictionary);
    av_dict_free(&dictionary);
    if (code < 0) {
        Error error = av_error(code, "the " + s.codec + " encoder refuses " + std::to_string(s.width) +
                                         " x " + std::to_string(s.height) +
                                         (s.kbps ? " at " + std::to_string(codec.bit_rate) + " bit/s" : "") +
                                         (s.speed.empty() ? "" : " with preset '" + s.speed + "'"));
        error.code = ErrorCode::invalid;
        return error;
    }
    if (takes_regions(s.codec))
        for (const VideoRegion& region : s.regions)
            state->regions.push_back({sizeof(AVRegionOfInterest), region.top, region.bottom, region.left, region.right,
                                      {int(std::lround(region.qp_offset * 16)), kQpRange * 16}});
    state->hevc = s.codec == "hevc";
    state->annex_b = s.codec == "h264" || state->hevc;
    state->config = extradata_of(codec);
    if (state->annex_b) state->config = without_sei(state->config, state->hevc);
    return VideoEncoder(std::move(state));
}

Result<std::vector<VideoPacket>> VideoEncoder::encode(const YuvImage& picture, bool key) {
    State& state = *state_;
    assert(picture.width == state.settings.width && picture.height == state.settings.height);
    assert(picture.chroma_width * 2 == picture.width);
    const FramePtr frame = make_frame();
    frame->format = AV_PIX_FMT_YUV420P;
    frame->width = picture.width;
    frame->height = picture.height;
    frame->color_range = state.codec->color_range;
    frame->colorspace = state.codec->colorspace;
    frame->color_primaries = state.codec->color_primaries;
    frame->color_trc = state.codec->color_trc;
    frame->chroma_location = state.codec->chroma_sample_location;
    if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
    for (int p = 0; p < 3; ++p) {
        const int w = p ? picture.chroma_width : picture.width,
                  h = p ? picture.chroma_height : picture.height;
        av_image_copy_plane(frame->data[p], frame->linesize[p], picture.planes[p].data(), w, w, h);
    }
    if (!state.regions.empty()) {
        const std::size_t size = state.regions.size() * sizeof(AVRegionOfInterest);
        AVFrameSideData* side = allocated(av_frame_new_side_data(frame.get(), AV_FRAME_DATA_REGIONS_OF_INTEREST, size));
        std::memcpy(side->data, state.regions.data(), size);
    }
    frame->quality = state.codec->global_quality;   // the native MPEG-4 encoder goes by this one
    frame->pts = state.fed++;
    frame->pict_type = key ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
    if (const int code = avcodec_send_frame(state.codec.get(), frame.get()); code < 0)
        return av_error(code, state.settings.codec + " encoder failed");
    return state.receive(false);
}

Result<std::vector<VideoPacket>> VideoEncoder::finish() {
    if (const int code = avcodec_send_frame(state_->codec.get(), nullptr); code < 0)
        return av_error(code, state_->settings.codec + " encoder failed");
    return state_->receive(true);
}

}  // namespace mien::media
