#include "player/live_decoder.hpp"

namespace mien::player {

void LiveDecoder::restart() {
    open_ = false;
    sound_ = {};
    last_given_ = -1;
}

std::optional<decoder::SoundDecoder::Block> LiveDecoder::hear(const protocol::LiveObject& object) {
    decoder::SoundDecoder& decoder = *stream_.sound;
    const std::size_t preroll = decoder.preroll_packets();
    if (object.index == 0) {
        sound_.warm = sound_.open && sound_.warm && object.group > sound_.group && object.first_time == sound_.end;
        if (!sound_.warm) decoder.restart();
        sound_.group = object.group;
        sound_.next = 0;
        sound_.first = object.first_time;
        sound_.open = true;
    }
    if (!sound_.open || object.group != sound_.group || object.index != sound_.next) return sound_.open = false, std::nullopt;
    ++sound_.next;
    const bool warms_up = object.index < preroll;
    if (warms_up && sound_.warm) return std::nullopt;
    auto sound = decoder.next(object.object.bytes);
    if (!sound.ok()) {
        ++damaged_;
        return sound_.open = false, std::nullopt;
    }
    if (warms_up) return std::nullopt;
    sound_.warm = true;
    decoder::SoundDecoder::Block block{sound_.first + std::int64_t(object.index - preroll) * decoder.packet_samples(), std::move(*sound)};
    sound_.end = block.first_sample + block.sound.length();
    return block;
}

std::vector<PlayFrame> LiveDecoder::add(const protocol::LiveObject& object) {
    std::vector<PlayFrame> frames;
    if (object.slot != stream_.motion_slots.front()) return frames;
    if (object.index == 0) {
        if (object.group <= group_) last_given_ = -1;   // a source goes back only when its stream has begun anew
        stream_.motion.begin_group();
        group_ = object.group;
        next_ = 0;
        open_ = true;
    }
    if (!open_ || object.group != group_ || object.index != next_) return open_ = false, frames;
    ++next_;
    auto decoded = stream_.motion.decode(object.object, object.first_time);
    if (!decoded.ok()) {
        ++damaged_;
        return open_ = false, frames;
    }
    for (model::Motion& motion : *decoded) {
        if (motion.frame <= last_given_) continue;   // times that go back are nothing to show
        last_given_ = motion.frame;
        frames.push_back({.frame = last_given_, .motion = std::move(motion)});
    }
    return frames;
}

}  // namespace mien::player
