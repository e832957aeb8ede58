#pragma once

#include <cstdint>
#include <vector>

#include "protocol/stream_file.hpp"

namespace mien::net {

/// The order in which a stored stream is handed out: group by group, of each the slots that are selected when it begins, what is texture last, so
/// that a line that is too slow keeps motion and sound.
class GroupWalk {
public:
    /// `reader` outlives the walk.
    explicit GroupWalk(const protocol::StreamFileReader& reader);

    void start(std::uint32_t group);                       ///< goes on with this group
    void select(std::uint64_t slots) { slots_ = slots; }   ///< bit s: slot s; of the next group that has not begun
    /// What comes next; null at the end. Valid until the walk is changed.
    const protocol::IndexEntry* peek();
    void pop();                                            ///< takes it: its group has begun

private:
    const protocol::StreamFileReader& reader_;
    std::uint64_t slots_ = ~std::uint64_t(0), textures_ = 0;
    std::size_t entry_ = 0;                                // of the index: where the next group begins
    std::vector<std::size_t> group_;                       // entries of the group that has begun, the next one last
};

}  // namespace mien::net
