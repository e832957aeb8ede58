#pragma once

#include <cstdint>
#include <cstdlib>

#include "coding/range_coder.hpp"

namespace mien::coding {

/// How every signed integer becomes binary decisions: a zero flag, a sign, the class floor(log2 |v|) in unary, then the bits
/// below the top one, of which the first is modelled and the rest are plain.
struct Binarisation {
    static constexpr int kBins = 24;      ///< 0 zero flag, 1..13 class, 14..23 first bit below the top one, by class
    static constexpr int kMaxClass = 26;  ///< |v| < 2^27
    /// A quantiser that is shifted by half a step is far less often zero, so models may keep the first decisions of its numbers apart.
    static constexpr int kShiftedBins = 4;
    static constexpr int shifted_bin(int bin) {
        return bin == 0 ? kBins : bin == class_bin(0) ? kBins + 1 : bin == class_bin(1) ? kBins + 2 : bin == first_bit_bin(1) ? kBins + 3 : bin;
    }
    static constexpr std::int32_t kMaxMagnitude = (1 << 27) - 1;

    static constexpr int class_bin(int cls) { return 1 + (cls < 12 ? cls : 12); }
    static constexpr int first_bit_bin(int cls) { return 14 + (cls < 9 ? cls : 9); }
};

/// Writes or reads `value`. code_bin(bit, bin) and code_sign(bit) code one modelled decision each.
template <class Coder, class CodeBin, class CodeSign>
void code_integer(Coder& coder, std::int32_t& value, CodeBin&& code_bin, CodeSign&& code_sign) {
    const std::uint32_t magnitude = Coder::kDecodes ? 0u : std::uint32_t(std::abs(std::int64_t(value)));
    int nonzero = magnitude != 0;
    code_bin(nonzero, 0);
    if (!nonzero) {
        value = 0;
        return;
    }
    int negative = Coder::kDecodes ? 0 : value < 0;
    code_sign(negative);
    const int top = Coder::kDecodes ? 0 : 31 - __builtin_clz(magnitude);
    int cls = 0;
    for (; cls < Binarisation::kMaxClass; ++cls) {
        int more = cls < top;
        code_bin(more, Binarisation::class_bin(cls));
        if (!more) break;
    }
    std::uint32_t below = magnitude & ((1u << cls) - 1);
    if (cls > 0) {
        int first = int(below >> (cls - 1) & 1);
        code_bin(first, Binarisation::first_bit_bin(cls));
        std::uint32_t rest = below & ((1u << (cls - 1)) - 1);
        code_plain(coder, rest, cls - 1);
        below = std::uint32_t(first) << (cls - 1) | rest;
    }
    const std::int32_t decoded = std::int32_t(1u << cls | below);
    value = negative ? -decoded : decoded;
}

}  // namespace mien::coding
