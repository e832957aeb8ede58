#include "decoder/av_sound.hpp"

#include <string>

#include "media/sound_codec.hpp"

namespace mien::decoder {

struct SoundDecoder::State {
    protocol::SoundInfo info;
    media::PacketSoundDecoder packets;
};

SoundDecoder::SoundDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
SoundDecoder::SoundDecoder(SoundDecoder&&) noexcept = default;
SoundDecoder& SoundDecoder::operator=(SoundDecoder&&) noexcept = default;
SoundDecoder::~SoundDecoder() = default;

Result<SoundDecoder> SoundDecoder::create(const protocol::Track& track, const protocol::Rung& rung) {
    const auto* info = std::get_if<protocol::SoundInfo>(&track.info);
    if (!info) return Error{ErrorCode::invalid, "track '" + track.name + "' is no sound track"};
    if (info->channels < 1 || info->channels > 8 || info->sample_rate < 1 || info->sample_rate > 768000 ||
        info->packet_samples < 1 || info->packet_samples > 65536 || info->preroll % info->packet_samples != 0)
        return Error{ErrorCode::invalid,
                     "sound track '" + track.name + "' has a rate, packet length or pre-roll that cannot be"};
    MIEN_TRY(packets, media::PacketSoundDecoder::open(rung.codec, rung.codec_config, int(info->sample_rate),
                                                      info->channels));
    return SoundDecoder(std::unique_ptr<State>(new State{*info, std::move(packets)}));
}

void SoundDecoder::restart() {
    state_->packets.restart();
}

std::size_t SoundDecoder::preroll_packets() const {
    return state_->info.preroll / state_->info.packet_samples;
}

std::uint32_t SoundDecoder::packet_samples() const {
    return state_->info.packet_samples;
}

Result<Sound> SoundDecoder::next(ByteView packet) {
    const protocol::SoundInfo& info = state_->info;
    Sound sound{int(info.sample_rate), info.channels, {}};
    auto done = state_->packets.decode(packet, sound.samples);
    if (done && sound.length() != std::int64_t(info.packet_samples))
        done = Error{ErrorCode::damaged, "a packet of sound has another length than the track announces"};
    if (done) return sound;
    restart();
    return done.error();
}

Result<SoundDecoder::Block> SoundDecoder::decode(const protocol::Group& group) {
    State& state = *state_;
    const protocol::SoundInfo& info = state.info;
    const auto fail = [&](Error error) {
        error.message = "sound group at sample " + std::to_string(group.first_time) + ": " + error.message;
        return error;
    };
    const std::size_t preroll = info.preroll / info.packet_samples;
    if (group.objects.size() < preroll) return fail({ErrorCode::damaged, "fewer packets than its pre-roll"});
    if (info.samples > 0 && (group.first_time < 0 || std::uint64_t(group.first_time) > info.samples))
        return fail({ErrorCode::damaged, "starts outside the sound"});

    state.packets.restart();
    Block block;
    block.first_sample = group.first_time;
    block.sound = {int(info.sample_rate), info.channels, {}};
    std::vector<float>& samples = block.sound.samples;
    for (std::size_t i = 0; i < group.objects.size(); ++i) {
        const std::size_t before = samples.size();
        if (auto done = state.packets.decode(group.objects[i].bytes, samples); !done)
            return fail(done.error());
        if (samples.size() - before != std::size_t(info.packet_samples) * info.channels)
            return fail({ErrorCode::damaged,
                         "packet " + std::to_string(i) + " has another length than the track announces"});
        if (i < preroll) samples.clear();
    }
    if (info.samples > 0) {
        const std::uint64_t left = (info.samples - std::uint64_t(group.first_time)) * info.channels;
        if (samples.size() > left) samples.resize(left);
    }
    return block;
}

}  // namespace mien::decoder
