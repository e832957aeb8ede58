#include "player/jitter_buffer.hpp"

#include <algorithm>
#include <cassert>

namespace mien::player {

JitterBuffer::JitterBuffer(std::size_t capacity, std::size_t enough)
    : capacity_(std::max<std::size_t>(capacity, 1)), enough_(std::clamp<std::size_t>(enough, 1, capacity_)) {}

void JitterBuffer::push(PlayFrame frame) {
    assert(has_room() && (frames_.empty() || frames_.back().frame < frame.frame));
    frames_.push_back(std::move(frame));
}

void JitterBuffer::make_room() {
    for (; !has_room(); ++dropped_) frames_.pop_front();
}

void JitterBuffer::clear() {
    frames_.clear();
    finished_ = false;
}

std::optional<std::int64_t> JitterBuffer::first() const {
    return frames_.empty() ? std::nullopt : std::optional(frames_.front().frame);
}

std::optional<PlayFrame> JitterBuffer::take(std::int64_t due) {
    if (frames_.empty() || frames_.front().frame > due) return std::nullopt;
    while (frames_.size() > 1 && frames_[1].frame <= due) {
        frames_.pop_front();
        ++dropped_;
    }
    return pop();
}

std::optional<PlayFrame> JitterBuffer::pop() {
    if (frames_.empty()) return std::nullopt;
    PlayFrame frame = std::move(frames_.front());
    frames_.pop_front();
    return frame;
}

}  // namespace mien::player
