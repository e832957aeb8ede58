#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "samples/performance.hpp"
#include "samples/performance_liveliness.hpp"

namespace mien::samples {
namespace {

struct Expression {
    double seconds;  // from the start of this expression to the start of the next
    std::vector<std::pair<std::string_view, float>> weights;  // a name without side sets both sides
};

/// Muscle groups apart first, then faces that mean something.
const std::vector<Expression>& expressions() {
    static const std::vector<Expression> all = {
        {0.9, {}},
        {1.0, {{"JawOpen", .75f}}},
        {0.9, {{"MouthSmile", .85f}, {"CheekSquint", .5f}}},
        {0.8, {{"MouthPucker", .9f}}},
        {0.8, {{"MouthFunnel", .85f}, {"JawOpen", .15f}}},
        {0.9, {{"MouthFrown", .75f}, {"MouthShrugLower", .4f}}},
        {0.8, {{"MouthStretch", .6f}, {"MouthLowerDown", .5f}, {"JawOpen", .08f}}},
        {0.7, {{"MouthUpperUp", .65f}, {"NoseSneer", .35f}}},
        {0.7, {{"MouthRollLower", .6f}, {"MouthRollUpper", .5f}, {"MouthPress", .3f}}},
        {0.7, {{"MouthLeft", .7f}}},
        {0.7, {{"MouthRight", .7f}}},
        {0.7, {{"JawLeft", .6f}, {"JawOpen", .12f}}},
        {0.7, {{"JawRight", .6f}, {"JawOpen", .12f}}},
        {0.8, {{"CheekPuff", .85f}, {"MouthPress", .25f}}},
        {0.8, {{"BrowInnerUp", .8f}, {"BrowOuterUp", .8f}, {"EyeWide", .45f}}},
        {0.8, {{"BrowDown", .8f}, {"EyeSquint", .5f}}},
        {0.8, {{"NoseSneer", .8f}, {"EyeSquint", .4f}}},
        {0.7, {{"EyeBlinkLeft", 1.f}, {"CheekSquintLeft", .6f}, {"MouthSmileLeft", .35f}}},
        {0.7, {{"EyeBlinkRight", 1.f}, {"CheekSquintRight", .6f}, {"MouthSmileRight", .35f}}},
        {1.1, {{"MouthSmile", 1.f}, {"CheekSquint", .7f}, {"EyeSquint", .25f}, {"JawOpen", .22f}, {"MouthUpperUp", .25f}}},
        {1.1, {{"BrowInnerUp", .9f}, {"BrowOuterUp", .9f}, {"EyeWide", .8f}, {"JawOpen", .5f}, {"MouthFunnel", .15f}}},
        {1.1, {{"BrowDown", .9f}, {"NoseSneer", .5f}, {"EyeSquint", .35f}, {"MouthPress", .5f}, {"MouthUpperUp", .15f}}},
        {1.1, {{"BrowInnerUp", .8f}, {"MouthFrown", .7f}, {"MouthShrugLower", .35f}, {"EyeSquint", .15f}}},
        {1.0, {{"NoseSneer", .7f}, {"MouthUpperUpLeft", .5f}, {"BrowDown", .4f}, {"MouthFrown", .3f}}},
        {1.0, {{"MouthSmile", .45f}, {"CheekSquint", .25f}}},
    };
    return all;
}

void add_expression(const Expression& expression, float amount, std::array<float, kArkitCount>& weights) {
    for (const auto& [name, value] : expression.weights)
        for (std::string_view side : {"", "Left", "Right"}) {
            const int i = arkit_index(std::string(name).append(side));
            if (i >= 0) weights[std::size_t(i)] += amount * value;
        }
}

}  // namespace

Performance perform_expressions(Rational frame_rate, double seconds, std::uint64_t seed) {
    double once = 0;
    for (const Expression& e : expressions()) once += e.seconds;
    const std::int64_t frames = frames_in(seconds > 0 ? seconds : once, frame_rate);
    seconds = double(frames) / frame_rate.value();
    const Liveliness life(seconds, {}, {}, seed);
    Performance performance{frame_rate, std::vector<Instant>(std::size_t(frames)), std::nullopt};
    for (std::int64_t f = 0; f < frames; ++f) {
        const double time = double(f) / frame_rate.value();
        Instant& instant = performance.instants[std::size_t(f)];
        double start = std::floor(time / once) * once;
        for (const Expression& e : expressions()) {
            // In over a third of the time, held, and out into the next one's beginning.
            const double in = (time - start) / (0.38 * e.seconds), out = (start + 1.12 * e.seconds - time) / (0.42 * e.seconds);
            const double x = std::clamp(std::min(in, out), 0.0, 1.0);
            add_expression(e, float(x * x * x * (x * (6 * x - 15) + 10)), instant.weights);
            start += e.seconds;
        }
        life.add(time, instant);
    }
    return performance;
}

}  // namespace mien::samples
