#include "player/damage_log.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace mien::player {
namespace {

constexpr double kTouch = 1e-6;             // seconds
constexpr std::size_t kMostStretches = 1000;   // nobody reads more of them, and a hostile stream may have one in every frame

std::string clock(double seconds) {
    const auto hundredths = std::int64_t(100 * seconds + 0.5);
    return fmt::format("{}:{:02}.{:02}", hundredths / 6000, hundredths / 100 % 60, hundredths % 100);
}

}  // namespace

const char* name_of(protocol::TrackKind kind) {
    return kind == protocol::TrackKind::motion ? "motion" : kind == protocol::TrackKind::texture ? "texture" : "sound";
}

std::string describe(const Damage& damage) {
    return fmt::format("{} damaged or missing from {} to {}", name_of(damage.track), clock(damage.first), clock(damage.end));
}

void DamageLog::note(const Damage& damage) {
    const std::lock_guard lock(mutex_);
    const auto touches = [&](const Damage& known) {
        return known.track == damage.track && damage.first <= known.end + kTouch && damage.end >= known.first - kTouch;
    };
    if (const auto known = std::ranges::find_if(stretches_, touches); known != stretches_.end()) {
        known->first = std::min(known->first, damage.first);
        known->end = std::max(known->end, damage.end);
    } else if (stretches_.size() < kMostStretches) {
        stretches_.push_back(damage);
    }
}

std::vector<Damage> DamageLog::stretches() const {
    const std::lock_guard lock(mutex_);
    return stretches_;
}

}  // namespace mien::player
