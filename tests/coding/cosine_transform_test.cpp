#include "coding/cosine_transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mien::coding {
namespace {

TEST(CosineTransform, IntegerInverseFollowsTheRealOneForEveryLength) {
    std::mt19937 random(1);
    for (int n = 1; n <= CosineTransform::kMaxLength; ++n) {
        const CosineTransform& transform = CosineTransform::of(n);
        std::vector<std::int32_t> coefficients(std::size_t(n), 0);
        for (auto& c : coefficients) c = std::int32_t(random() % 401) - 200;
        std::vector<std::int64_t> samples(std::size_t(n), 0);
        transform.inverse(coefficients.data(), samples.data());
        for (int t = 0; t < n; ++t) {
            double want = 0;
            for (int f = 0; f < n; ++f)
                want += coefficients[std::size_t(f)] * std::sqrt((f ? 2.0 : 1.0) / n) * std::cos(M_PI * (2 * t + 1) * f / (2.0 * n));
            ASSERT_NEAR(double(samples[std::size_t(t)]) / 16, want, 0.04) << n;
        }
    }
}

TEST(CosineTransform, ForwardUndoesInverse) {
    const CosineTransform& transform = CosineTransform::of(30);
    std::vector<double> samples(30), coefficients(30);
    std::mt19937 random(2);
    std::vector<std::int32_t> truth(30);
    for (auto& c : truth) c = std::int32_t(random() % 101) - 50;
    std::vector<std::int64_t> sixteenths(30);
    transform.inverse(truth.data(), sixteenths.data());
    for (std::size_t t = 0; t < 30; ++t) samples[t] = double(sixteenths[t]) / 16;
    transform.forward(samples.data(), coefficients.data());
    for (std::size_t f = 0; f < 30; ++f) EXPECT_NEAR(coefficients[f], truth[f], 0.3);
}

}  // namespace
}  // namespace mien::coding
