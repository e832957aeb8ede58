#pragma once

#include <optional>
#include <vector>

#include "player/play_frame.hpp"
#include "player/stream_model.hpp"

namespace mien::player {

/// Turns the objects of a live stream into frames, each as it comes. Of what cannot be decoded the rest of the group is left out. No threads.
class LiveDecoder {
public:
    /// `stream` outlives the decoder.
    explicit LiveDecoder(StreamModel& stream) : stream_(stream) {}

    void restart();                                              ///< after a seek
    std::vector<PlayFrame> add(const protocol::LiveObject& object);
    /// A packet of sound: what it sounds like, none while a decoder only warms up. Groups that follow each other go on without doing that again.
    std::optional<decoder::SoundDecoder::Block> hear(const protocol::LiveObject& object);

    std::uint64_t damaged_groups() const { return damaged_; }

private:
    StreamModel& stream_;
    std::uint32_t group_ = 0, next_ = 0;                         // the object that follows
    bool open_ = false;                                          // a group is being decoded
    std::int64_t last_given_ = -1;
    std::uint64_t damaged_ = 0;

    struct Sound {
        std::uint32_t group = 0, next = 0;
        std::int64_t first = 0;                                  // sample after the group's pre-roll
        std::int64_t end = -1;                                   // sample after what was heard last
        bool open = false, warm = false;                         // warm: the decoder is where the group's pre-roll would bring it
    } sound_;
};

}  // namespace mien::player
