#include "encoder/sound_encoder.hpp"

#include <algorithm>

#include "media/sound_codec.hpp"

namespace mien::encoder {
namespace {

EncodedSound in_groups(media::SoundPackets run, const SoundOptions& options) {
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

double kbps_of(const EncodedSound& encoded) {
    std::size_t bytes = 0;
    for (const protocol::Group& group : encoded.groups)
        for (const protocol::Object& object : group.objects) bytes += object.bytes.size();
    return encoded.info.samples ? 8e-3 * double(bytes) * encoded.info.sample_rate / double(encoded.info.samples) : 0;
}

}  // namespace

Result<EncodedSound> encode_sound(const Sound& sound, const SoundOptions& options) {
    constexpr int kTries = 5;
    constexpr double kOver = 1.01, kUnder = 0.95, kWorthwhile = 0.99;
    MIEN_TRY(first, media::compress_sound(sound, options.codec, options.kbps));
    EncodedSound best = in_groups(std::move(first), options);
    double taken = kbps_of(best), aim = options.kbps;
    if (taken <= kOver * options.kbps) return best;
    // Codecs of variable rate miss their aim, and every group says its pre-roll again: aims between one that took too much and one that
    // took too little. A codec has a least rate, too, below which nothing is saved.
    double too_much = aim, too_little = 0, last = taken;
    for (int tries = 1; tries < kTries; ++tries) {
        aim = too_little > 0 ? (too_much + too_little) / 2 : aim * options.kbps / last;
        auto run = media::compress_sound(sound, options.codec, aim);
        if (!run.ok()) break;
        EncodedSound encoded = in_groups(std::move(*run), options);
        const double now = kbps_of(encoded);
        const bool over = now > kOver * options.kbps;
        if (over && now > kWorthwhile * last) break;
        if (over ? now < taken : taken > kOver * options.kbps || now > taken) best = std::move(encoded), taken = now;
        if (!over && now >= kUnder * options.kbps) break;
        (over ? too_much : too_little) = aim;
        if (over) last = now;
    }
    return best;
}

}  // namespace mien::encoder
