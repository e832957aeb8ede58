#pragma once

#include <string>

#include "core/image.hpp"
#include "core/result.hpp"
#include "protocol/stream.hpp"

namespace mien::encoder {

struct SoundOptions {
    std::string codec = "opus";  ///< opus, aac
    double kbps = 48;            ///< at most, all groups with their pre-roll, as far as the codec can
    std::int64_t group_frames = 30;
    Rational frame_rate{30, 1};  ///< of the visual tracks: a packet belongs to the group in which it starts
    std::int64_t frames = 0;     ///< of the visual tracks; packets after the last group belong to it
};

struct EncodedSound {
    protocol::SoundInfo info;
    Rational time_base;  ///< seconds per sample
    Bytes codec_config;
    std::string codec;
    std::vector<protocol::Group>
        groups;  ///< slot 0; one object per packet, the pre-roll packets of a group first
};

/// Resamples where the codec needs it and takes out the encoder's delay: sample 0 of the stream is sample 0
/// of `sound`. Every group starts with exactly info.preroll / info.packet_samples packets from before it (in
/// the first group they hold silence), whose decoded samples are swallowed; group.first_time is the first
/// sample after them, so it is a multiple of packet_samples. Groups in which no packet starts (the sound is
/// over, or a group is shorter than a packet) are left out; with group_frames 0 there is one group. The last
/// packet may pass the end: info.samples says where the sound ends.
Result<EncodedSound> encode_sound(const Sound& sound, const SoundOptions& options);

}  // namespace mien::encoder
