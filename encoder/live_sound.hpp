#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/image.hpp"
#include "core/result.hpp"
#include "media/sound_codec.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

struct LiveSoundOptions {
    int sample_rate = 48000;   ///< of what is captured
    int channels = 1;          ///< 1 or 2
    double kbps = 48;
};

/// Encodes sound as it is captured: low-delay Opus, a packet every 10 ms. Packets that were lost on the way are silence.
class LiveSound {
public:
    static Result<LiveSound> open(const LiveSoundOptions& options);

    protocol::SoundInfo info() const;
    const Bytes& codec_config() const { return encoder_.codec_config(); }

    struct Packet {
        Bytes bytes;
        std::int64_t position = 0;   ///< of the first sample it decodes to, in samples of the stream's rate since the sender's sample 0
        bool anew = false;           ///< its position does not follow the last one's
    };
    /// `first`: the sender's count of samples before these. What came already is left out; a step of more than a second either way is
    /// a sender that counts anew. Errors: another rate or number of channels than was opened for.
    Result<std::vector<Packet>> add(std::int64_t first, const Sound& sound);

    /// What a decoder swallows before the first packet, info().preroll long.
    const std::vector<Bytes>& lead() const { return lead_; }

private:
    LiveSound(const LiveSoundOptions& options, media::PacketSoundEncoder encoder);
    Result<void> begin(std::int64_t first);

    LiveSoundOptions options_;
    media::PacketSoundEncoder encoder_;
    std::optional<media::SoundResampler> resampler_;
    std::vector<Bytes> lead_;
    std::optional<std::int64_t> next_;   // sample that should come
    std::int64_t position_ = 0;          // of pending_, at the stream's rate
    bool anew_ = false;
    std::vector<float> pending_;         // at the stream's rate, less than a packet between calls
};

}  // namespace mien::encoder
