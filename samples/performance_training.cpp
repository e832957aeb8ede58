#include "samples/performance_training.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

namespace mien::samples {
namespace {

using Weights = std::vector<std::pair<std::string_view, float>>;  // a name without side sets both sides

struct Path {
    std::string_view name;
    std::vector<Weights> stops;  // neutral comes before the first
};

const std::vector<Path>& session() {
    static const std::vector<Path> all = {
        {"brows raised", {{{"BrowInnerUp", 1.f}, {"BrowOuterUp", 1.f}, {"EyeWide", .5f}}}},
        {"brows knit", {{{"BrowDown", 1.f}, {"EyeSquint", .6f}}}},
        {"nose wrinkled", {{{"NoseSneer", 1.f}, {"MouthUpperUp", .6f}, {"BrowDown", .4f}, {"EyeSquint", .5f}}}},
        {"cheeks", {{{"MouthSmile", .7f}, {"CheekSquint", .4f}}, {{"MouthSmile", 1.f}, {"CheekSquint", 1.f}, {"EyeSquint", .5f}, {"MouthDimple", .4f}}}},
        {"lips", {{{"MouthFrown", 1.f}, {"MouthShrugLower", .8f}, {"MouthPress", .4f}}, {{"MouthPucker", 1.f}, {"MouthFunnel", .3f}}}},
        {"jaw", {{{"JawOpen", .45f}, {"MouthStretch", .7f}}, {{"JawOpen", 1.f}, {"MouthStretch", .3f}}}},
    };
    return all;
}

void add(const Weights& weights, float amount, Instant& instant) {
    for (const auto& [name, value] : weights)
        for (const std::string_view side : {"", "Left", "Right"})
            if (const int i = arkit_index(std::string(name).append(side)); i >= 0) instant.weights[std::size_t(i)] += amount * value;
}

float ease(float x) { return x * x * (3 - 2 * x); }

/// The instant at 0 .. 1 of a path: eased from stop to stop.
Instant along_path(const std::vector<Weights>& stops, float at) {
    Instant instant;
    const float place = at * float(stops.size());
    const int stop = std::min(int(place), int(stops.size()) - 1);
    const float part = ease(place - float(stop));
    if (stop > 0) add(stops[std::size_t(stop - 1)], 1 - part, instant);
    add(stops[std::size_t(stop)], part, instant);
    return instant;
}

}  // namespace

TrainingSession perform_training(int frames_each, int extra, std::uint64_t seed) {
    assert(frames_each >= 2 && extra >= 0);
    TrainingSession result;
    for (const Path& path : session()) {
        result.takes.push_back({std::string(path.name), result.performance.frames()});
        for (int f = 0; f < frames_each; ++f) result.performance.instants.push_back(along_path(path.stops, float(f) / float(frames_each - 1)));
    }
    if (extra > 0) {
        result.takes.push_back({"range of motion", result.performance.frames()});
        const Performance motion = perform_expressions({30, 1}, 0, seed);
        for (int f = 0; f < extra; ++f) {
            Instant instant = motion.instants[std::size_t((std::int64_t(f) * 2 + 1) * motion.frames() / (2 * extra))];
            instant.head = {};
            result.performance.instants.push_back(instant);
        }
    }
    return result;
}

Performance perform_unseen(std::string_view name, int frames) {
    std::vector<Weights> stops;
    if (name == kAsymmetricSmile)
        stops = {{{"MouthSmileLeft", .9f}, {"CheekSquintLeft", .7f}, {"EyeSquintLeft", .4f}, {"MouthDimpleLeft", .3f}, {"MouthLeft", .25f}},
                 {{"MouthSmileLeft", .6f}, {"CheekSquintLeft", .4f}, {"JawOpen", .15f}, {"MouthUpperUpLeft", .3f}}};
    else if (name == kRaisedBrow)
        stops = {{{"BrowOuterUpRight", 1.f}, {"BrowInnerUp", .25f}, {"EyeWideRight", .3f}}, {{"BrowOuterUpRight", .8f}, {"BrowDownLeft", .6f}, {"EyeSquintLeft", .3f}}};
    assert(!stops.empty() && frames >= 2);
    Performance performance;
    for (int f = 0; f < frames; ++f) performance.instants.push_back(along_path(stops, float(f) / float(frames - 1)));
    return performance;
}

}  // namespace mien::samples
