#pragma once

#include <cstdint>
#include <optional>

namespace mien::tools {

/// Which frame of the stream a packet is: numbers that come late, twice, or not at all. What has a number goes by it; no time is involved.
class FrameCounter {
public:
    /// longest: frames that may be lost in a row; a larger step, either way, is a sender that has begun anew and goes on without a gap.
    explicit FrameCounter(std::int64_t longest) : longest_(longest) {}

    /// How many frames the stream goes on by: 1 for the next one, more when some are lost; none for what is late or was there already.
    std::optional<std::int64_t> step(std::uint32_t sequence) {
        const std::int64_t ahead = last_ ? std::int64_t(static_cast<std::int32_t>(sequence - *last_)) : 1;
        const bool anew = ahead > longest_ || ahead < -longest_;
        if (ahead <= 0 && !anew) return std::nullopt;
        last_ = sequence;
        return anew ? 1 : ahead;
    }

private:
    std::int64_t longest_;
    std::optional<std::uint32_t> last_;
};

}  // namespace mien::tools
