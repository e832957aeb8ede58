#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace mien::coding {

/// By how much what was new at one side of a face has been new at the other: least squares over the values coded so far, in
/// 1/65536, within +-1.
struct SideGain {
    static constexpr std::int64_t kOne = 1 << 16;
    std::int64_t product = 0, square = 4096;

    std::int64_t value() const { return std::clamp<std::int64_t>(product * kOne / square, -kOne, kOne); }
    void learn(std::int64_t seen, std::int64_t found) {
        seen = std::clamp(seen, -kOne, kOne);
        found = std::clamp(found, -kOne, kOne);
        product += seen * found;
        square += seen * seen;
        if (square > std::int64_t(1) << 42 || std::abs(product) > std::int64_t(1) << 42) product /= 2, square = std::max<std::int64_t>(square / 2, 1);
    }
};

}  // namespace mien::coding
