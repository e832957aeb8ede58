#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "player/play_frame.hpp"

namespace mien::player {

/// Decoded frames between the decoder's bursts and the screen's even beat. Knows no time and no threads: who fills it
/// asks for room, who empties it says which frame is due.
class JitterBuffer {
public:
    /// capacity: frames it holds at most. enough: frames from which playing may start (at most capacity).
    JitterBuffer(std::size_t capacity, std::size_t enough);

    bool has_room() const { return frames_.size() < capacity_; }
    void push(PlayFrame frame);                  ///< in ascending order, only when there is room
    void finish() { finished_ = true; }          ///< no more frames will come
    void resume() { finished_ = false; }         ///< more come after all: a live stream whose publisher is back
    /// Makes room by leaving out the oldest: what is live does not wait.
    void make_room();
    void clear();                                ///< after a seek

    /// Enough to start or go on after running empty.
    bool ready() const { return frames_.size() >= enough_ || (finished_ && !frames_.empty()); }
    bool empty() const { return frames_.empty(); }
    bool drained() const { return finished_ && frames_.empty(); }
    std::size_t size() const { return frames_.size(); }
    std::optional<std::int64_t> first() const;

    /// The newest frame that is not after `due`; older ones are dropped and counted. None when all are still to come.
    std::optional<PlayFrame> take(std::int64_t due);
    /// The next frame whatever the time.
    std::optional<PlayFrame> pop();
    std::uint64_t dropped() const { return dropped_; }

private:
    std::deque<PlayFrame> frames_;
    std::size_t capacity_, enough_;
    std::uint64_t dropped_ = 0;
    bool finished_ = false;
};

}  // namespace mien::player
