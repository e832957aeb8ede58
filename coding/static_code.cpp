#include "coding/static_code.hpp"

#include <algorithm>
#include <cmath>

namespace mien::coding {
namespace {
struct Ignore {
    static constexpr bool kDecodes = false;
    void code(int&, Probability) {}
    void fail() {}
};
}  // namespace

void StaticCounter::add(std::int32_t value) {
    Ignore coder;
    code_integer(
        coder, value, [&](int& bit, int bin) { ++seen_[std::size_t(bin)][std::size_t(bit)]; }, [](int&) {});
}

StaticRow StaticCounter::row() const {
    StaticRow row{};
    for (std::size_t b = 0; b < row.size(); ++b) {
        const double zeros = double(seen_[b][0]), ones = double(seen_[b][1]);
        if (zeros + ones == 0) continue;
        const double logit = std::log((ones + 0.02) / (zeros + 0.02));
        row[b] = std::int8_t(std::clamp(std::lround(logit * 4), -31l, 31l));
    }
    return row;
}

void write_static_vectors(RangeEncoder& coder, const MotionBasis& basis, const MotionShape& shape) {
    const StaticRow* row = basis.static_codes.data() + basis.channels(shape);
    for (std::int32_t v : basis.mean) code_static(coder, v, *row);
    for (const auto& component : basis.components) {
        ++row;
        for (std::int32_t v : component) code_static(coder, v, *row);
    }
}

void read_static_vectors(RangeDecoder& coder, MotionBasis& basis, const MotionShape& shape, std::uint32_t k) {
    const StaticRow* row = basis.static_codes.data() + shape.side_channels() + k;
    const std::size_t d = std::size_t(shape.dimension());
    basis.mean.assign(d, 0);
    for (std::int32_t& v : basis.mean) {
        code_static(coder, v, *row);
        if (coder.failed()) return;
    }
    for (std::uint32_t j = 0; j < k; ++j) {
        ++row;
        basis.components.emplace_back(d, 0);
        for (std::int32_t& v : basis.components.back()) {
            code_static(coder, v, *row);
            if (coder.failed()) return;
        }
    }
}

}  // namespace mien::coding
