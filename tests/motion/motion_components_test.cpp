#include "encoder/motion_components.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/parallel.hpp"

namespace mien::encoder {
namespace {

/// Three components and a little noise.
Eigen::MatrixXf low_rank(Eigen::Index d, Eigen::Index frames) {
    std::mt19937 random(3);
    const auto uniform = [&](Eigen::Index rows, Eigen::Index columns, float size) {
        Eigen::MatrixXf values(rows, columns);
        for (float& v : values.reshaped()) v = size * (float(random()) / 2147483648.0f - 1);
        return values;
    };
    const Eigen::MatrixXf vectors = uniform(d, 3, 1), coefficients = uniform(3, frames, 1);
    return vectors * coefficients + uniform(d, frames, 0.01f);
}

// Sides that are summed in several parts, and sides so large that the range finder takes over.
TEST(MotionComponents, AreTheSameForAnyThreadCount) {
    for (const auto& [d, frames] : {std::pair(60, 700), std::pair(700, 60), std::pair(710, 720)}) {
        const Eigen::MatrixXf values = low_rank(d, frames);
        MotionComponents one;
        for (const int threads : {1, 2, 7}) {
            set_thread_count(threads);
            MotionComponents found = find_components(values, 1e-3 * double(values.squaredNorm()), 10);
            EXPECT_EQ(found.vectors.cols(), 3);
            if (threads == 1) one = found;
            const bool same = found.mean == one.mean && found.vectors == one.vectors && found.coefficients == one.coefficients;
            EXPECT_TRUE(same && found.left_out == one.left_out) << d << " x " << frames << " with " << threads << " threads";
        }
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace mien::encoder
