#include "tools/motion_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::tools {

void MotionError::add(const float* truth, const float* received, std::int64_t N, int dimension) {
    std::array<double, 3> centre{};
    std::int64_t present = 0;
    for (std::int64_t i = 0; i < N; ++i) {
        if (std::isnan(truth[i * dimension])) continue;
        ++present;
        for (int c = 0; c < dimension; ++c) centre[std::size_t(c)] += truth[i * dimension + c];
    }
    if (present == 0) return;
    for (double& c : centre) c /= double(present);
    for (std::int64_t i = 0; i < N; ++i) {
        if (std::isnan(truth[i * dimension])) continue;
        double squared = 0;
        for (int c = 0; c < dimension; ++c) {
            const double error = double(truth[i * dimension + c]) - received[i * dimension + c];
            const double arm = truth[i * dimension + c] - centre[std::size_t(c)];
            squared += error * error;
            spread_ += arm * arm;
        }
        squared_sum_ += squared;
        distance_sum_ += std::sqrt(squared);
        // A received NaN must not pass unseen.
        if (!(std::sqrt(squared) <= peak_)) peak_ = std::sqrt(squared);
    }
    points_ += present;
}

double MotionError::rms() const { return points_ ? std::sqrt(squared_sum_ / double(points_)) : 0; }

double still_rms(const std::vector<float>& values, std::int64_t N, int dimension) {
    double squared = 0;
    std::int64_t points = 0;
    const auto per_frame = std::size_t(N * dimension);
    for (std::size_t i = 0; i < per_frame; ++i) {
        double sum = 0, squares = 0;   // about the first frame's value, against cancellation
        std::int64_t present = 0;
        float origin = NAN;
        for (std::size_t at = i; at < values.size(); at += per_frame) {
            if (std::isnan(values[at])) continue;
            if (std::isnan(origin)) origin = values[at];
            const double x = double(values[at]) - origin;
            sum += x, squares += x * x, ++present;
        }
        if (present) squared += squares - sum * sum / double(present);
        if (i % std::size_t(dimension) == 0) points += present;
    }
    return points ? std::sqrt(std::max(0.0, squared / double(points))) : 0;
}

double MotionError::kg_percent() const { return spread_ > 0 ? 100 * std::sqrt(squared_sum_ / spread_) : 0; }

}  // namespace mien::tools
