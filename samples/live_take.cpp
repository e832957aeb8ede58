#include "samples/live_take.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/live_link.hpp"
#include "io/sound_file.hpp"
#include "samples/performance_liveliness.hpp"

namespace mien::samples {

Result<Performance> perform_take(const std::filesystem::path& csv, const std::optional<std::filesystem::path>& sound) {
    MIEN_TRY(take, io::read_live_link(csv));
    std::vector<int> place;  // of each column among the ARKit weights
    int known = 0;
    for (std::string name : take.weights.names) {
        if (!name.empty() && name[0] >= 'a' && name[0] <= 'z') name[0] = char(name[0] - 'a' + 'A');
        place.push_back(arkit_index(name));
        known += place.back() >= 0;
    }
    if (known == 0) return Error{ErrorCode::missing, fmt::format("{} has no ARKit weight column", csv.string())};
    Performance performance{take.frame_rate, {}, std::nullopt};
    for (std::int64_t f = 0; f < take.weights.frames; ++f) {
        Instant instant;
        for (std::size_t c = 0; c < place.size(); ++c)
            if (place[c] >= 0) instant.weights[std::size_t(place[c])] = take.weights.frame(f)[c];
        if (!take.head_pose.empty()) instant.head = turned_on_neck(take.head_pose[std::size_t(f)].rotation);
        instant.gaze = take.gaze.empty() ? gaze_of(instant.weights) : take.gaze[std::size_t(f)];
        performance.instants.push_back(instant);
    }
    if (sound) {
        MIEN_TRY(heard, io::read_sound(*sound));
        performance.sound = std::move(heard);
    }
    return performance;
}

}  // namespace mien::samples
