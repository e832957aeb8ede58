#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "player/damage_log.hpp"
#include "player/play_frame.hpp"
#include "player/stream_model.hpp"

namespace mien::player {

/// Turns groups into frames, a little at a time, so that a whole clip in one group never has to fit in memory decoded.
/// A frame comes out with the texture of that very frame; where that is damaged or did not come, without any, so that the last picture
/// stays on the face. Frames whose motion is lost are left out. Both are noted in the log. No threads.
class GroupDecoder {
public:
    /// `stream` and `damage` outlive the decoder.
    GroupDecoder(StreamModel& stream, DamageLog& damage) : stream_(stream), damage_(damage), texture_rung_(stream.first_texture_rung) {}

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

    /// Frames of motion that have come, from the last restart on, reach to here: what a stream of known length lacks behind it is lost.
    std::int64_t motion_end() const { return motion_end_; }
    std::uint64_t damaged_groups() const { return damaged_groups_; }   ///< that came and could not be decoded
    const std::string& last_damage() const { return last_damage_; }

private:
    struct Pending {
        std::optional<protocol::Group> motion, texture;
        std::map<std::uint8_t, protocol::Group> refinements;   // of motion, by slot
    };
    /// Lacks nothing, not even a refinement.
    bool complete(const Pending& group) const {
        return group.motion && (group.texture || stream_.texture_rungs.empty()) && group.refinements.size() + 1 == stream_.motion_slots.size();
    }
    /// Nothing more will come for it.
    bool settled(std::uint32_t number, const Pending& group) const { return finished_ || number < newest_ || complete(group); }
    std::map<std::uint32_t, Pending>::const_iterator next_ready() const;
    bool begin_group();
    Result<void> begin_texture(protocol::Group group);
    void give_up(const std::string& why);
    void note(protocol::TrackKind track, std::int64_t first, std::int64_t end);
    void join(std::vector<decoder::TextureFrame> pictures, std::vector<PlayFrame>& frames);
    void show_without_texture(std::vector<PlayFrame>& frames);

    StreamModel& stream_;
    DamageLog& damage_;
    std::map<std::uint32_t, Pending> pending_;
    std::uint32_t newest_ = 0;                   // group that something has come of
    std::optional<std::uint32_t> begun_;         // the last group that was begun: what still comes of it is too late
    bool finished_ = false;
    std::int64_t motion_end_ = 0;

    bool open_ = false;                          // a group is being decoded
    std::map<std::int64_t, model::Motion> motions_;
    std::optional<protocol::Group> texture_;     // none: what is left of the group is shown without
    std::size_t texture_rung_ = 0;
    std::size_t next_object_ = 0;
    std::int64_t frames_ = 0;                    // of the group, by its motion
    std::int64_t last_given_ = -1;
    std::uint64_t damaged_groups_ = 0;
    std::string last_damage_;
};

}  // namespace mien::player
