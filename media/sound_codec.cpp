#include "media/sound_codec.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "media/pcm.hpp"

namespace mien::media {
namespace {

const AVCodec* find_sound_encoder(const std::string& codec) {
    if (codec == "opus") return avcodec_find_encoder_by_name("libopus");
    if (codec == "aac") return avcodec_find_encoder_by_name("aac");
    return nullptr;
}

const AVCodec* find_sound_decoder(const std::string& codec) {
    // libopus gives every packet's samples at once; FFmpeg's own delays some of them.
    const AVCodec* found = codec == "opus" ? avcodec_find_decoder_by_name("libopus") : nullptr;
    if (!found && codec == "opus") found = avcodec_find_decoder(AV_CODEC_ID_OPUS);
    if (codec == "aac") found = avcodec_find_decoder_by_name("aac");
    return found;
}

bool aac_takes(int rate) {
    constexpr int kRates[] = {96000, 88200, 64000, 48000, 44100, 32000,
                              24000, 22050, 16000, 12000, 11025, 8000};
    return std::find(std::begin(kRates), std::end(kRates), rate) != std::end(kRates);
}

SwrPtr make_resampler(int channels, int from, int to) {
    SwrContext* context = nullptr;
#if MIEN_AV_CHANNEL_LAYOUT
    AVChannelLayout layout;
    av_channel_layout_default(&layout, channels);
    swr_alloc_set_opts2(&context, &layout, AV_SAMPLE_FMT_FLT, to, &layout, AV_SAMPLE_FMT_FLT, from, 0,
                        nullptr);
    av_channel_layout_uninit(&layout);
#else
    const std::int64_t layout = av_get_default_channel_layout(channels);
    context = swr_alloc_set_opts(nullptr, layout, AV_SAMPLE_FMT_FLT, to, layout, AV_SAMPLE_FMT_FLT, from, 0,
                                 nullptr);
#endif
    SwrPtr resampler(context);
    if (!resampler) return nullptr;
    av_opt_set_int(context, "filter_size", 64, 0);  // the default cuts speech sibilants at 44.1 -> 48 kHz
    if (swr_init(context) < 0) return nullptr;
    return resampler;
}

Result<CodecPtr> open_sound_encoder(const std::string& name, int sample_rate, int channels, double kbps,
                                    bool low_delay = false) {
    const AVCodec* encoder = find_sound_encoder(name);
    if (!encoder) {
        std::string names;
        for (const char* known : {"opus", "aac"})
            if (find_sound_encoder(known)) names += (names.empty() ? "" : ", ") + std::string(known);
        return Error{ErrorCode::unavailable,
                     "there is no sound codec '" + name + "' here; available are " + names};
    }
    CodecPtr codec(allocated(avcodec_alloc_context3(encoder)));
    codec->sample_rate = sample_rate;
    codec->sample_fmt = name == "opus" ? AV_SAMPLE_FMT_FLT : AV_SAMPLE_FMT_FLTP;
    codec->time_base = {1, sample_rate};
    codec->bit_rate = std::llround(kbps * 1000);
    codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    set_channels(*codec, channels);
    AVDictionary* options = nullptr;
    // Noise substitution draws from a generator that runs through the whole sound: groups would not decode
    // alone.
    if (name == "aac") av_dict_set(&options, "aac_pns", "0", 0);
    if (low_delay) {
        av_dict_set(&options, "application", "lowdelay", 0);
        av_dict_set(&options, "frame_duration", "10", 0);
        av_dict_set(&options, "vbr", "constrained", 0);  // a burst would come late
    }
    const int code = avcodec_open2(codec.get(), encoder, &options);
    av_dict_free(&options);
    if (code < 0) {
        Error error = av_error(code, "the " + name + " encoder refuses " + std::to_string(channels) +
                                         " channels at " + std::to_string(int(kbps)) + " kbit/s");
        error.code = ErrorCode::invalid;
        return error;
    }
    return codec;
}

}  // namespace

Result<Sound> resample(const Sound& sound, int sample_rate) {
    if (sound.sample_rate == sample_rate) return sound;
    quiet_libraries();
    const SwrPtr resampler = make_resampler(sound.channels, sound.sample_rate, sample_rate);
    if (!resampler)
        return Error{ErrorCode::invalid, "sound of " + std::to_string(sound.channels) + " channels at " +
                                             std::to_string(sound.sample_rate) + " Hz cannot be brought to " +
                                             std::to_string(sample_rate) + " Hz"};
    Sound out{sample_rate, sound.channels, {}};
    const std::int64_t wanted = rescale(sound.length(), {1, sound.sample_rate}, {1, sample_rate});
    out.samples.reserve(std::size_t(wanted) * sound.channels);
    constexpr std::int64_t kChunk = 1 << 15;
    std::vector<float> chunk;
    for (std::int64_t at = 0;; at += kChunk) {
        const std::int64_t count = std::clamp<std::int64_t>(sound.length() - at, 0, kChunk);
        const int room = swr_get_out_samples(resampler.get(), int(count));
        if (room < 0) return av_error(room, "sound does not resample");
        chunk.resize(std::size_t(std::max(room, 1)) * sound.channels);
        std::uint8_t* to[] = {reinterpret_cast<std::uint8_t*>(chunk.data())};
        const std::uint8_t* from[] = {
            reinterpret_cast<const std::uint8_t*>(sound.samples.data() + (count ? at * sound.channels : 0))};
        const int made =
            swr_convert(resampler.get(), to, std::max(room, 1), count ? from : nullptr, int(count));
        if (made < 0) return av_error(made, "sound does not resample");
        out.samples.insert(out.samples.end(), chunk.begin(),
                           chunk.begin() + std::ptrdiff_t(made) * sound.channels);
        if (count == 0 && made == 0) break;
    }
    out.samples.resize(std::size_t(wanted) * sound.channels);
    return out;
}

Result<SoundPackets> compress_sound(const Sound& original, const std::string& name, double kbps) {
    quiet_libraries();
    if (original.channels < 1 || original.channels > 8 || original.sample_rate < 1)
        return Error{ErrorCode::invalid, "sound of " + std::to_string(original.channels) + " channels at " +
                                             std::to_string(original.sample_rate) +
                                             " Hz: one to eight channels can be encoded"};
    for (std::size_t i = 0; i < original.samples.size(); ++i)
        if (!std::isfinite(original.samples[i]))
            return Error{ErrorCode::invalid,
                         "sound sample " + std::to_string(i / original.channels) + " is not a number"};
    const bool opus = name == "opus";
    const int rate = opus || !aac_takes(original.sample_rate) ? 48000 : original.sample_rate;
    MIEN_TRY(codec, open_sound_encoder(name, rate, original.channels, kbps));
    MIEN_TRY(sound, resample(original, rate));

    SoundPackets out;
    out.sample_rate = rate;
    out.channels = sound.channels;
    out.samples = sound.length();
    out.packet_samples = codec->frame_size;
    out.preroll_packets = opus ? 4 : 1;
    out.codec_config = extradata_of(*codec);
    // Silence in front makes the delay whole packets: then packets, like groups, start on sample 0.
    const std::int64_t lead = std::int64_t(out.preroll_packets) * out.packet_samples - codec->initial_padding;
    if (lead < 0)
        return Error{ErrorCode::unavailable, "the " + name + " encoder's delay is longer than its pre-roll"};
    const std::int64_t wanted =
        out.preroll_packets + (out.samples + out.packet_samples - 1) / out.packet_samples;

    const PacketPtr packet = make_packet();
    const auto receive = [&]() -> Result<void> {
        for (;;) {
            const int code = avcodec_receive_packet(codec.get(), packet.get());
            if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
            if (code < 0) return av_error(code, name + " encoder failed");
            const auto* first = reinterpret_cast<const std::byte*>(packet->data);
            if (std::int64_t(out.packets.size()) < wanted)
                out.packets.emplace_back(first, first + packet->size);
            av_packet_unref(packet.get());
        }
    };
    for (std::int64_t fed = 0; std::int64_t(out.packets.size()) < wanted; fed += out.packet_samples) {
        const FramePtr frame = make_frame();
        frame->nb_samples = out.packet_samples;
        frame->format = codec->sample_fmt;
        frame->sample_rate = rate;
        set_channels(*frame, sound.channels);
        if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
        const bool planar = av_sample_fmt_is_planar(codec->sample_fmt);
        for (int c = 0; c < sound.channels; ++c) {
            float* to = reinterpret_cast<float*>(frame->extended_data[planar ? c : 0]) + (planar ? 0 : c);
            for (int i = 0; i < out.packet_samples; ++i, to += planar ? 1 : sound.channels) {
                const std::int64_t at = fed + i - lead;
                *to = at >= 0 && at < out.samples ? sound.samples[std::size_t(at) * sound.channels + c] : 0.f;
            }
        }
        frame->pts = fed;
        if (const int code = avcodec_send_frame(codec.get(), frame.get()); code < 0)
            return av_error(code, name + " encoder failed");
        MIEN_CHECK(receive());
        // Encoders hold back a packet or two; far more means one that gives none.
        if (fed > lead + out.samples + 64 * std::int64_t(out.packet_samples))
            return Error{ErrorCode::unavailable, "the " + name + " encoder gives no packets"};
    }
    return out;
}

struct SoundResampler::State {
    SwrPtr resampler;
    int channels = 1;
};

SoundResampler::SoundResampler(std::unique_ptr<State> state) : state_(std::move(state)) {}
SoundResampler::SoundResampler(SoundResampler&&) noexcept = default;
SoundResampler& SoundResampler::operator=(SoundResampler&&) noexcept = default;
SoundResampler::~SoundResampler() = default;

Result<SoundResampler> SoundResampler::open(int channels, int from, int to) {
    quiet_libraries();
    auto state = std::make_unique<State>();
    state->channels = channels;
    state->resampler = make_resampler(channels, from, to);
    if (!state->resampler)
        return Error{ErrorCode::invalid, "sound of " + std::to_string(channels) + " channels at " +
                                             std::to_string(from) + " Hz cannot be brought to " +
                                             std::to_string(to) + " Hz"};
    return SoundResampler(std::move(state));
}

Result<void> SoundResampler::add(const std::vector<float>& samples, std::vector<float>& resampled) {
    const int count = int(samples.size()) / state_->channels;
    const int room = std::max(1, swr_get_out_samples(state_->resampler.get(), count));
    const std::size_t before = resampled.size();
    resampled.resize(before + std::size_t(room) * std::size_t(state_->channels));
    std::uint8_t* to[] = {reinterpret_cast<std::uint8_t*>(resampled.data() + before)};
    const std::uint8_t* from[] = {reinterpret_cast<const std::uint8_t*>(samples.data())};
    const int made = swr_convert(state_->resampler.get(), to, room, from, count);
    resampled.resize(before + std::size_t(std::max(0, made)) * std::size_t(state_->channels));
    if (made < 0) return av_error(made, "sound does not resample");
    return {};
}

struct PacketSoundEncoder::State {
    int channels = 1;
    CodecPtr codec;
    Bytes config;
    std::int64_t time = 0;
};

PacketSoundEncoder::PacketSoundEncoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
PacketSoundEncoder::PacketSoundEncoder(PacketSoundEncoder&&) noexcept = default;
PacketSoundEncoder& PacketSoundEncoder::operator=(PacketSoundEncoder&&) noexcept = default;
PacketSoundEncoder::~PacketSoundEncoder() = default;

Result<PacketSoundEncoder> PacketSoundEncoder::open(int channels, double kbps) {
    quiet_libraries();
    auto state = std::make_unique<State>();
    state->channels = channels;
    MIEN_TRY(codec, open_sound_encoder("opus", kSampleRate, channels, kbps, true));
    if (codec->frame_size != kPacketSamples)
        return Error{ErrorCode::unavailable, "the opus encoder here has no packets of 10 ms"};
    state->codec = std::move(codec);
    state->config = extradata_of(*state->codec);
    return PacketSoundEncoder(std::move(state));
}

const Bytes& PacketSoundEncoder::codec_config() const {
    return state_->config;
}

int PacketSoundEncoder::delay() const {
    return state_->codec->initial_padding;
}

Result<Bytes> PacketSoundEncoder::encode(const float* samples) {
    State& state = *state_;
    const FramePtr frame = make_frame();
    frame->nb_samples = kPacketSamples;
    frame->format = state.codec->sample_fmt;
    frame->sample_rate = kSampleRate;
    set_channels(*frame, state.channels);
    if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
    std::copy_n(samples, std::size_t(kPacketSamples) * std::size_t(state.channels),
                reinterpret_cast<float*>(frame->data[0]));
    frame->pts = std::exchange(state.time, state.time + kPacketSamples);
    const PacketPtr packet = make_packet();
    int code = avcodec_send_frame(state.codec.get(), frame.get());
    if (code >= 0) code = avcodec_receive_packet(state.codec.get(), packet.get());
    if (code < 0) return av_error(code, "the opus encoder failed");
    const auto* first = reinterpret_cast<const std::byte*>(packet->data);
    return Bytes(first, first + packet->size);
}

struct PacketSoundDecoder::State {
    std::string name;
    int sample_rate = 0, channels = 0;
    CodecPtr codec;
    FramePtr frame = make_frame();
};

PacketSoundDecoder::PacketSoundDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
PacketSoundDecoder::PacketSoundDecoder(PacketSoundDecoder&&) noexcept = default;
PacketSoundDecoder& PacketSoundDecoder::operator=(PacketSoundDecoder&&) noexcept = default;
PacketSoundDecoder::~PacketSoundDecoder() = default;

Result<PacketSoundDecoder> PacketSoundDecoder::open(const std::string& name, ByteView config, int sample_rate,
                                                    int channels) {
    quiet_libraries();
    const AVCodec* decoder = find_sound_decoder(name);
    if (!decoder)
        return Error{ErrorCode::unavailable, "there is no decoder for the sound codec '" + name + "' here"};
    auto state = std::make_unique<State>();
    state->name = name;
    state->sample_rate = sample_rate;
    state->channels = channels;
    state->codec.reset(allocated(avcodec_alloc_context3(decoder)));
    AVCodecContext& codec = *state->codec;
    set_extradata(codec, config);
    codec.sample_rate = sample_rate;
    set_channels(codec, channels);
    codec.request_sample_fmt = AV_SAMPLE_FMT_FLT;
    codec.flags2 |= AV_CODEC_FLAG2_SKIP_MANUAL;  // the pre-roll is ours to swallow
    codec.err_recognition = AV_EF_EXPLODE;
    if (const int code = avcodec_open2(&codec, decoder, nullptr); code < 0)
        return av_error(code, "the " + name + " decoder refuses the codec headers");
    return PacketSoundDecoder(std::move(state));
}

void PacketSoundDecoder::restart() {
    avcodec_flush_buffers(state_->codec.get());
}

Result<void> PacketSoundDecoder::decode(ByteView bytes, std::vector<float>& samples) {
    State& state = *state_;
    if (bytes.empty()) return Error{ErrorCode::damaged, state.name + " packet is empty"};
    const PacketPtr packet = make_packet(bytes);
    if (const int code = avcodec_send_packet(state.codec.get(), packet.get()); code < 0)
        return av_error(code, state.name + " packet does not decode");
    for (;;) {
        const int code = avcodec_receive_frame(state.codec.get(), state.frame.get());
        if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return {};
        if (code < 0) return av_error(code, state.name + " packet does not decode");
        if (state.frame->sample_rate != state.sample_rate || channels_of(*state.frame) != state.channels)
            return Error{ErrorCode::mismatch,
                         state.name + " packet changes the sample rate or the number of channels"};
        if (!append_samples(*state.frame, samples))
            return Error{ErrorCode::invalid, state.name + " packet has an unknown sample format"};
    }
}

}  // namespace mien::media
