#include "net/group_walk.hpp"

#include <algorithm>

namespace mien::net {

GroupWalk::GroupWalk(const protocol::StreamFileReader& reader) : reader_(reader) {
    for (const protocol::Track& track : reader.header().tracks)
        if (track.kind == protocol::TrackKind::texture)
            for (const protocol::Rung& rung : track.rungs) textures_ |= std::uint64_t(1) << rung.slot;
}

void GroupWalk::start(std::uint32_t group) {
    entry_ = reader_.first_entry(group);
    group_.clear();
}

const protocol::IndexEntry* GroupWalk::peek() {
    const auto& index = reader_.index();
    if (!group_.empty()) return &index[group_.back()];
    // A group of which nothing is wanted is passed over, once and for all. Of one that has not begun this may be asked again.
    for (; entry_ < index.size(); ++entry_) {
        const protocol::IndexEntry* texture = nullptr;
        for (std::size_t e = entry_; e < index.size() && index[e].group == index[entry_].group; ++e) {
            if (!(slots_ >> index[e].slot & 1)) continue;
            if (!(textures_ >> index[e].slot & 1)) return &index[e];
            if (!texture) texture = &index[e];
        }
        if (texture) return texture;
        while (entry_ + 1 < index.size() && index[entry_ + 1].group == index[entry_].group) ++entry_;
    }
    return nullptr;
}

void GroupWalk::pop() {
    if (group_.empty()) {
        const auto& index = reader_.index();
        if (!peek()) return;
        const std::uint32_t number = index[entry_].group;
        for (; entry_ < index.size() && index[entry_].group == number; ++entry_)
            if (slots_ >> index[entry_].slot & 1) group_.push_back(entry_);
        std::ranges::stable_partition(group_, [&](std::size_t e) { return !(textures_ >> index[e].slot & 1); });
        std::ranges::reverse(group_);
    }
    group_.pop_back();
}

}  // namespace mien::net
