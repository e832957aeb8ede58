#include "protocol/stream.hpp"

namespace mien::protocol {

std::vector<const Rung*> rung_ladder(const Track& track) {
    std::vector<const Rung*> ladder;
    for (const Rung& rung : track.rungs)
        if (ladder.empty() ? !rung.refines : rung.refines == ladder.back()->slot) ladder.push_back(&rung);
    return ladder;
}

}  // namespace mien::protocol
