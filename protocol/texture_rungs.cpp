#include "protocol/texture_rungs.hpp"

namespace mien::protocol {

const Rung& texture_rung(const Track& track, std::size_t wanted) {
    const Rung* best = &track.rungs.front();  // the first always stands alone
    std::size_t number = 0;
    for (const Rung& rung : track.rungs)
        if (!rung.refines && number++ <= wanted) best = &rung;
    return *best;
}

std::size_t texture_rung_within(const Track& track, double bits_per_second) {
    std::size_t number = 0, best = 0;
    for (const Rung& rung : track.rungs) {
        if (rung.refines) continue;
        if (rung.bits_per_second <= bits_per_second) best = number;
        ++number;
    }
    return best;
}

Rung::Size texture_size(const Track& track, const Rung& rung) {
    const auto& info = std::get<TextureInfo>(track.info);
    return rung.size.value_or(Rung::Size{info.width, info.height});
}

}  // namespace mien::protocol
