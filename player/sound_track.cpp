#include "player/sound_track.hpp"

#include <algorithm>
#include <cmath>

namespace mien::player {

void SoundTrack::add(decoder::SoundDecoder::Block block) {
    const std::lock_guard lock(mutex_);
    blocks_.push_back(std::move(block));
}

double SoundTrack::end() const {
    const std::lock_guard lock(mutex_);
    double end = 0;
    for (const auto& block : blocks_)
        end = std::max(end, double(block.first_sample + block.sound.length()) / block.sound.sample_rate);
    return end;
}

Sound SoundTrack::between(double start, double end) const {
    const std::lock_guard lock(mutex_);
    if (blocks_.empty()) return {};
    Sound track;
    track.sample_rate = blocks_.front().sound.sample_rate;
    track.channels = blocks_.front().sound.channels;
    const std::int64_t first = std::llround(start * track.sample_rate), last = std::llround(end * track.sample_rate);
    track.samples.resize(std::size_t(std::max<std::int64_t>(0, last - first)) * track.channels);
    for (const auto& block : blocks_) {
        if (block.sound.channels != track.channels) continue;
        const std::int64_t from = std::max(first, block.first_sample);
        const std::int64_t to = std::min(last, block.first_sample + block.sound.length());
        if (from >= to) continue;
        std::copy_n(block.sound.samples.begin() + (from - block.first_sample) * track.channels, (to - from) * track.channels,
                    track.samples.begin() + (from - first) * track.channels);
    }
    return track;
}

}  // namespace mien::player
