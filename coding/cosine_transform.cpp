#include "coding/cosine_transform.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>

namespace mien::coding {

CosineTransform::CosineTransform(int length) : length_(length), table_(std::size_t(length) * std::size_t(length)) {
    assert(length >= 1 && length <= kMaxLength);
    // Rounding to 2^-20 hides the last digits of anyone's cos.
    for (int t = 0; t < length; ++t)
        for (int f = 0; f < length; ++f) {
            const double norm = std::sqrt((f ? 2.0 : 1.0) / length);
            const int turn = (2 * t + 1) * f % (4 * length);
            const double c = norm * std::cos(std::numbers::pi * turn / (2.0 * length));
            table_[std::size_t(t * length + f)] = std::int32_t(std::lround(c * (1 << kScaleBits)));
        }
}

void CosineTransform::inverse(const std::int32_t* coefficients, std::int64_t* samples) const {
    constexpr int shift = kScaleBits - kFractionBits;
    for (int t = 0; t < length_; ++t) {
        const std::int32_t* row = table_.data() + t * length_;
        std::int64_t sum = 0;
        for (int f = 0; f < length_; ++f) sum += std::int64_t(row[f]) * coefficients[f];
        samples[t] = (sum + (1 << (shift - 1))) >> shift;
    }
}

void CosineTransform::forward(const double* samples, double* coefficients) const {
    for (int f = 0; f < length_; ++f) {
        double sum = 0;
        for (int t = 0; t < length_; ++t) sum += double(table_[std::size_t(t * length_ + f)]) * samples[t];
        coefficients[f] = sum / (1 << kScaleBits);
    }
}

const CosineTransform& CosineTransform::of(int length) {
    static std::array<std::unique_ptr<CosineTransform>, kMaxLength + 1> made;
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    auto& transform = made[std::size_t(length)];
    if (!transform) transform = std::make_unique<CosineTransform>(length);
    return *transform;
}

}  // namespace mien::coding
