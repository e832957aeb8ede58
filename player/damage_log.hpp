#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "protocol/stream.hpp"

namespace mien::player {

/// A stretch of one track that did not come or could not be decoded, seconds.
struct Damage {
    protocol::TrackKind track;
    double first = 0, end = 0;
};

const char* name_of(protocol::TrackKind kind);
/// "texture damaged or missing from 0:01.00 to 0:02.00"
std::string describe(const Damage& damage);

/// What could not be shown or heard so far. Stretches that touch are one; what is met again after a seek is not new. Thread-safe.
class DamageLog {
public:
    void note(const Damage& damage);
    std::vector<Damage> stretches() const;   ///< in the order in which they were met

private:
    mutable std::mutex mutex_;
    std::vector<Damage> stretches_;
};

}  // namespace mien::player
