#include "io/frame_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/frame_rate.hpp"
#include "io/fault_list.hpp"
#include "io/limits.hpp"

namespace mien::io {

Result<FrameTimes> number_frames(const std::vector<double>& times, double longest_gap) {
    FrameTimes result;
    if (times.empty()) return result;
    result.frame_of_row = {0};
    std::vector<double> steps;
    FaultList faults;
    for (std::size_t i = 1; i < times.size(); ++i) {
        const double step = times[i] - times[i - 1];
        if (!(step >= 0 && step <= longest_gap))
            faults.add(fmt::format("row {}: the time {} by {:.3f}", i, step < 0 ? "runs back" : "jumps", std::abs(step)));
        steps.push_back(step);
    }
    if (!faults.empty()) return faults.error();
    if (steps.empty()) return result;

    std::vector<double> sorted = steps;
    const auto middle = sorted.begin() + std::ptrdiff_t(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double usual = *middle;
    if (!(usual > 0)) return Error{ErrorCode::invalid, "row 1: most times are the same"};
    double sum = 0;
    std::int64_t kept = 0;
    for (const double step : steps) {
        const double frames = std::round(step / usual);
        if (frames == 1) {
            sum += step;
            ++kept;
        }
        const double frame = double(result.frame_of_row.back()) + frames;
        if (frame >= double(kMaxFrames)) return Error{ErrorCode::limit_exceeded, fmt::format("row {}: too many frames are missing", result.frame_of_row.size())};
        result.frame_of_row.push_back(std::int64_t(frame));
    }
    result.step = sum / double(kept);
    return result;
}

std::optional<Rational> usual_rate(double measured) {
    if (!(measured >= kLowestFrameRate && measured <= kHighestFrameRate)) return std::nullopt;
    Rational best = make_rational(std::llround(measured * 1000), 1000);
    double nearest = 0.005;
    for (const Rational rate : {Rational{10, 1}, {12, 1}, {15, 1}, {20, 1}, {24000, 1001}, {24, 1}, {25, 1}, {30000, 1001}, {30, 1},
                                {48, 1}, {50, 1}, {60000, 1001}, {60, 1}, {90, 1}, {100, 1}, {120, 1}}) {
        const double off = std::abs(rate.value() / measured - 1);
        if (off < nearest) {
            nearest = off;
            best = rate;
        }
    }
    return best;
}

}  // namespace mien::io
