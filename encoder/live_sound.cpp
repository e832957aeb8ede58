#include "encoder/live_sound.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

namespace mien::encoder {
namespace {

constexpr int kRate = media::PacketSoundEncoder::kSampleRate, kPacket = media::PacketSoundEncoder::kPacketSamples;
// 80 ms, as RFC 7845 (section 4.6) has it: a decoder that joins there differs by -39 dB from one that heard all (after 40 ms by -25 dB).
constexpr int kPreroll = 8;

/// A number of samples at another rate, rounded down.
std::int64_t at_rate(std::int64_t samples, int from, int to) {
    const std::int64_t whole = samples / from, rest = samples % from;
    return whole * to + (rest * to) / from;
}

}  // namespace

LiveSound::LiveSound(const LiveSoundOptions& options, media::PacketSoundEncoder encoder) : options_(options), encoder_(std::move(encoder)) {}

Result<LiveSound> LiveSound::open(const LiveSoundOptions& options) {
    MIEN_TRY(encoder, media::PacketSoundEncoder::open(options.channels, options.kbps));
    LiveSound sound(options, std::move(encoder));
    const std::vector<float> silence(std::size_t(kPacket * options.channels));
    for (int i = 0; i < kPreroll; ++i) {
        MIEN_TRY(packet, sound.encoder_.encode(silence.data()));
        sound.lead_.push_back(std::move(packet));
    }
    MIEN_CHECK(sound.begin(0));
    return sound;
}

protocol::SoundInfo LiveSound::info() const {
    protocol::SoundInfo info;
    info.sample_rate = std::uint32_t(kRate);
    info.channels = std::uint8_t(options_.channels);
    info.preroll = std::uint32_t(kPreroll * kPacket);
    info.packet_samples = std::uint32_t(kPacket);
    return info;
}

/// What was pending is of another time.
Result<void> LiveSound::begin(std::int64_t first) {
    if (options_.sample_rate != kRate) {
        MIEN_TRY(resampler, media::SoundResampler::open(options_.channels, options_.sample_rate, kRate));
        resampler_.emplace(std::move(resampler));
    }
    pending_.clear();
    position_ = at_rate(first, options_.sample_rate, kRate) - encoder_.delay();
    anew_ = true;
    return {};
}

Result<std::vector<LiveSound::Packet>> LiveSound::add(std::int64_t first, const Sound& sound) {
    if (sound.sample_rate != options_.sample_rate || sound.channels != options_.channels)
        return Error{ErrorCode::mismatch, "the sound is of " + std::to_string(sound.channels) + " x " + std::to_string(sound.sample_rate) + " Hz instead of " +
                                              std::to_string(options_.channels) + " x " + std::to_string(options_.sample_rate)};
    const auto channels = std::size_t(options_.channels);
    if (!next_ || std::abs(first - *next_) > options_.sample_rate) {
        MIEN_CHECK(begin(first));
        next_ = first;
    }
    std::vector<float> samples;
    if (first > *next_) samples.resize(std::size_t(first - *next_) * channels);   // lost on the way
    const std::int64_t known = *next_ - first;
    if (known >= sound.length()) return std::vector<Packet>();
    samples.insert(samples.end(), sound.samples.begin() + std::ptrdiff_t(channels) * std::max<std::int64_t>(0, known), sound.samples.end());
    next_ = first + sound.length();
    if (resampler_) {
        MIEN_CHECK(resampler_->add(samples, pending_));
    } else {
        pending_.insert(pending_.end(), samples.begin(), samples.end());
    }

    std::vector<Packet> packets;
    std::size_t used = 0;
    for (; pending_.size() - used >= std::size_t(kPacket) * channels; used += std::size_t(kPacket) * channels) {
        MIEN_TRY(bytes, encoder_.encode(pending_.data() + used));
        packets.push_back({std::move(bytes), std::exchange(position_, position_ + kPacket), std::exchange(anew_, false)});
    }
    pending_.erase(pending_.begin(), pending_.begin() + std::ptrdiff_t(used));
    return packets;
}

}  // namespace mien::encoder
