#include "player/live_decoder.hpp"

namespace mien::player {

void LiveDecoder::restart() {
    open_ = false;
    last_given_ = -1;
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
