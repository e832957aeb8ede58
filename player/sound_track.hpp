#pragma once

#include <mutex>
#include <vector>

#include "decoder/av_sound.hpp"

namespace mien::player {

/// Collects decoded sound for writing it at once. Blocks may come from another thread, in any order and overlapping.
class SoundTrack {
public:
    void add(decoder::SoundDecoder::Block block);
    double end() const;    ///< seconds up to which there is sound
    /// What sounds from `start` to `end` (seconds); gaps are silent, and after the last block it is silent.
    Sound between(double start, double end) const;

private:
    mutable std::mutex mutex_;
    std::vector<decoder::SoundDecoder::Block> blocks_;
};

}  // namespace mien::player
