#pragma once

#include <array>
#include <cstdint>

#include "coding/integer_binarisation.hpp"
#include "coding/integer_model.hpp"
#include "coding/motion_basis.hpp"

/// Static entropy codes, as Guenter et al. 1998, section 7 have them: chances measured once per channel and per basis vector,
/// stored beside the basis, never adapted.
namespace mien::coding {

using StaticRow = std::array<std::int8_t, Binarisation::kBins>;  ///< logits in 1/4 per bin, -31 .. 31

inline Probability static_chance(std::int8_t level) { return logistic(level * 64); }

template <class Coder>
void code_static(Coder& coder, std::int32_t& value, const StaticRow& row) {
    code_integer(
        coder, value, [&](int& bit, int bin) { coder.code(bit, static_chance(row[std::size_t(bin)])); },
        [&](int& bit) { coder.code(bit, kHalf); });
}

/// A row: how many bins are in use, then six bits each.
template <class Coder>
void code_static_row(Coder& coder, StaticRow& row) {
    std::uint32_t used = 0;
    if (!Coder::kDecodes)
        for (std::uint32_t b = 0; b < row.size(); ++b)
            if (row[b]) used = b + 1;
    code_plain(coder, used, 5);
    if (used > row.size()) return coder.fail();
    for (std::uint32_t b = 0; b < used; ++b) {
        std::uint32_t level = std::uint32_t(row[b] + 32);
        code_plain(coder, level, 6);
        row[b] = std::int8_t(int(level) - 32);
    }
}

/// Measures the best row for a run of values.
class StaticCounter {
public:
    void add(std::int32_t value);
    StaticRow row() const;

private:
    std::array<std::array<std::uint64_t, 2>, Binarisation::kBins> seen_{};
};

void write_static_vectors(RangeEncoder& coder, const MotionBasis& basis, const MotionShape& shape);
void read_static_vectors(RangeDecoder& coder, MotionBasis& basis, const MotionShape& shape, std::uint32_t k);

}  // namespace mien::coding
