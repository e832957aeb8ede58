#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "player/play_frame.hpp"
#include "player/stream_model.hpp"

namespace mien::player {

/// Turns groups into frames, a little at a time, so that a whole clip in one group never has to fit in memory decoded.
/// A frame comes out only when motion and texture of that very frame are there; a damaged group is left out. No threads.
class GroupDecoder {
public:
    /// `stream` outlives the decoder.
    explicit GroupDecoder(StreamModel& stream) : stream_(stream) {}

    /// Forgets everything; frames before `first_frame` will be decoded but not given out (a seek into a group).
    void restart(std::int64_t first_frame);
    /// The next group of motion or texture, in the source's order.
    void add(protocol::Group group);
    void finish() { finished_ = true; }          ///< no more groups will come

    bool wants_group() const;                    ///< too little waits to be decoded
    bool has_work() const;                       ///< step() would do something
    bool drained() const { return finished_ && !has_work(); }
    /// Decodes one object further.
    std::vector<PlayFrame> step();
    /// Gives up the rest of the current group when a later one that starts at or before `due` waits: a slow machine
    /// drops frames instead of falling behind. Returns the frames given up.
    std::int64_t skip_to(std::int64_t due);

    std::uint64_t damaged_groups() const { return damaged_; }
    const std::string& last_damage() const { return last_damage_; }

private:
    struct Pending {
        std::optional<protocol::Group> motion, texture;
        std::map<std::uint8_t, protocol::Group> refinements;   // of motion, by slot
    };
    /// Can be shown; and lacks nothing, not even a refinement.
    bool usable(const Pending& group) const { return group.motion && (group.texture || stream_.texture_rungs.empty()); }
    bool complete(const Pending& group) const { return usable(group) && group.refinements.size() + 1 == stream_.motion_slots.size(); }
    /// Nothing more will come for it.
    bool settled(std::uint32_t number, const Pending& group) const { return finished_ || number < newest_ || complete(group); }
    std::map<std::uint32_t, Pending>::const_iterator next_ready() const;
    bool begin_group();
    void give_up(const std::string& why);
    void join(std::vector<decoder::TextureFrame> pictures, std::vector<PlayFrame>& frames);

    StreamModel& stream_;
    std::map<std::uint32_t, Pending> pending_;
    std::uint32_t newest_ = 0;                   // group that something has come of
    std::optional<std::uint32_t> begun_;         // the last group that was begun: what still comes of it is too late
    bool finished_ = false;
    std::int64_t first_wanted_ = 0;

    bool open_ = false;                          // a group is being decoded
    std::map<std::int64_t, model::Motion> motions_;
    protocol::Group texture_;
    std::size_t texture_rung_ = 0;
    std::size_t next_object_ = 0;
    std::int64_t frames_ = 0;                    // of the group, by its motion
    std::int64_t last_given_ = -1;
    std::uint64_t damaged_ = 0;
    std::string last_damage_;
};

}  // namespace mien::player
