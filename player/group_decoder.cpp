#include "player/group_decoder.hpp"

#include <algorithm>
#include <iterator>

namespace mien::player {
namespace {

using protocol::TrackKind;

constexpr std::size_t kWaitingGroups = 2;  // complete ones behind the current: enough for sound to run ahead

}  // namespace

void GroupDecoder::restart(std::int64_t first_frame) {
    pending_.clear();
    motions_.clear();
    texture_.reset();
    open_ = finished_ = false;
    newest_ = 0;
    begun_.reset();
    motion_end_ = first_frame;
    last_given_ = first_frame - 1;
}

void GroupDecoder::add(protocol::Group group) {
    // Of a group that has begun, another rung of texture comes when the connection dropped after the rung was changed.
    if (begun_ && group.group <= *begun_) return;
    newest_ = std::max(newest_, group.group);
    // What a group lacks now will never come.
    std::erase_if(pending_, [&](const auto& entry) { return entry.first < newest_ && !entry.second.motion; });
    if (group.group < newest_) return;
    Pending& pending = pending_[group.group];
    const auto& slots = stream_.motion_slots;
    if (group.slot == slots.front()) pending.motion = std::move(group);
    else if (std::find(slots.begin(), slots.end(), group.slot) != slots.end()) pending.refinements[group.slot] = std::move(group);
    else if (!pending.texture) pending.texture = std::move(group);
}

bool GroupDecoder::wants_group() const {
    if (finished_) return false;
    std::size_t waiting = 0;
    for (const auto& [number, group] : pending_) waiting += settled(number, group);
    return waiting < kWaitingGroups;
}

// Groups come in order of their numbers: what one lacks when a later one comes (or none will) will never be there, and it is shown without
// the texture and the refinements that are missing.
std::map<std::uint32_t, GroupDecoder::Pending>::const_iterator GroupDecoder::next_ready() const {
    return std::ranges::find_if(pending_, [&](const auto& entry) { return entry.second.motion && settled(entry.first, entry.second); });
}

bool GroupDecoder::has_work() const { return open_ || next_ready() != pending_.end(); }

bool GroupDecoder::begin_group() {
    const auto ready = next_ready();
    if (ready == pending_.end()) return false;
    begun_ = ready->first;
    Pending group = std::move(pending_.extract(ready).mapped());
    stream_.motion.begin_group();
    motions_.clear();
    std::int64_t frame = group.motion->first_time;
    for (std::size_t i = 0; i < group.motion->objects.size(); ++i) {
        const protocol::Object& object = group.motion->objects[i];
        std::vector<const protocol::Object*> refinements;
        for (std::size_t r = 1; r < stream_.motion_slots.size(); ++r) {
            const auto found = group.refinements.find(stream_.motion_slots[r]);
            const bool there = found != group.refinements.end() && i < found->second.objects.size();
            refinements.push_back(there ? &found->second.objects[i] : nullptr);
        }
        auto decoded = stream_.motion.decode(object, frame, refinements);
        if (!decoded.ok()) return give_up(decoded.error().message), motions_.clear(), false;
        for (model::Motion& motion : *decoded) motions_.emplace(motion.frame, std::move(motion));
        frame += object.frames;
    }
    frames_ = frame - group.motion->first_time;
    if (group.motion->first_time > motion_end_) note(TrackKind::motion, motion_end_, group.motion->first_time);
    motion_end_ = std::max(motion_end_, frame);
    texture_.reset();
    if (group.texture) {
        if (const auto begun = begin_texture(std::move(*group.texture)); !begun.ok()) give_up(begun.error().message);
    }
    return open_ = true;
}

Result<void> GroupDecoder::begin_texture(protocol::Group group) {
    texture_rung_ = stream_.texture_rung_of(group.slot).value_or(0);
    MIEN_CHECK(stream_.use_texture_rung(texture_rung_));
    stream_.texture->begin_group(group.first_time);
    next_object_ = 0;
    texture_ = std::move(group);
    return {};
}

void GroupDecoder::give_up(const std::string& why) {
    ++damaged_groups_;
    last_damage_ = why;
}

void GroupDecoder::note(TrackKind track, std::int64_t first, std::int64_t end) {
    const double rate = stream_.frame_rate.value();
    damage_.note({track, double(first) / rate, double(end) / rate});
}

void GroupDecoder::join(std::vector<decoder::TextureFrame> pictures, std::vector<PlayFrame>& frames) {
    for (decoder::TextureFrame& picture : pictures) {
        auto motion = motions_.extract(picture.frame);
        if (motion.empty() || picture.frame <= last_given_) continue;
        last_given_ = picture.frame;
        frames.push_back({.frame = picture.frame, .motion = std::move(motion.mapped()), .texture = std::move(picture), .texture_rung = texture_rung_});
    }
}

void GroupDecoder::show_without_texture(std::vector<PlayFrame>& frames) {
    const auto first = motions_.upper_bound(last_given_);
    if (first != motions_.end() && !stream_.texture_rungs.empty()) note(TrackKind::texture, first->first, motions_.rbegin()->first + 1);
    for (auto at = first; at != motions_.end(); ++at) {
        auto& [number, motion] = *at;
        frames.push_back({.frame = last_given_ = number, .motion = std::move(motion), .texture_rung = texture_rung_});
    }
    motions_.clear();
    texture_.reset();
    open_ = false;
}

std::vector<PlayFrame> GroupDecoder::step() {
    std::vector<PlayFrame> frames;
    if (!open_ && !begin_group()) return frames;
    if (!texture_) return show_without_texture(frames), frames;
    const bool last = next_object_ == texture_->objects.size();
    auto pictures = last ? stream_.texture->end_group(frames_) : stream_.texture->push(texture_->objects[next_object_++]);
    if (pictures.ok()) join(std::move(*pictures), frames);
    else give_up(pictures.error().message);
    if (last || !pictures.ok()) show_without_texture(frames);
    return frames;
}

std::int64_t GroupDecoder::skip_to(std::int64_t due) {
    if (!open_) return 0;
    for (const auto& [number, group] : pending_) {
        if (!group.motion || !settled(number, group) || group.motion->first_time > due) continue;
        const std::int64_t skipped = std::int64_t(motions_.size());
        motions_.clear();
        open_ = false;
        return skipped;
    }
    return 0;
}

}  // namespace mien::player
