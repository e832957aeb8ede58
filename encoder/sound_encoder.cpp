#include "encoder/sound_encoder.hpp"

#include <algorithm>

#include "media/sound_codec.hpp"

namespace mien::encoder {

Result<EncodedSound> encode_sound(const Sound& sound, const SoundOptions& options) {
    MIEN_TRY(run, media::compress_sound(sound, options.codec, options.kbps));
    EncodedSound out;
    out.codec = options.codec;
    out.codec_config = std::move(run.codec_config);
    out.time_base = make_rational(1, run.sample_rate);
    out.info.sample_rate = std::uint32_t(run.sample_rate);
    out.info.channels = std::uint8_t(run.channels);
    out.info.packet_samples = std::uint32_t(run.packet_samples);
    out.info.preroll = std::uint32_t(run.preroll_packets * run.packet_samples);
    out.info.samples = std::uint64_t(run.samples);

    const std::int64_t last_group =
        options.group_frames > 0 && options.frames > 0 ? (options.frames - 1) / options.group_frames : 0;
    for (std::int64_t i = run.preroll_packets; i < std::int64_t(run.packets.size()); ++i) {
        const std::int64_t start = (i - run.preroll_packets) * run.packet_samples;
        // The group in which it starts: floor(start / rate * frames per second / frames per group).
        std::int64_t number = 0;
        if (options.group_frames > 0)
            number =
                std::int64_t(__int128(start) * options.frame_rate.num /
                             (__int128(run.sample_rate) * options.frame_rate.den * options.group_frames));
        if (options.frames > 0) number = std::min(number, last_group);
        if (out.groups.empty() || out.groups.back().group != number) {
            protocol::Group group;
            group.group = std::uint32_t(number);
            group.first_time = start;
            for (std::int64_t p = i - run.preroll_packets; p < i; ++p)
                group.objects.push_back({1, run.packets[std::size_t(p)]});
            out.groups.push_back(std::move(group));
        }
        out.groups.back().objects.push_back({1, run.packets[std::size_t(i)]});
    }
    return out;
}

}  // namespace mien::encoder
