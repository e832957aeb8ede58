#pragma once

#include <cstdint>
#include <vector>

namespace mien::coding {

/// The orthonormal cosine transform (DCT-II) of one length, back from integer coefficients in integers only.
class CosineTransform {
public:
    static constexpr int kMaxLength = 128;
    static constexpr int kFractionBits = 4;  ///< samples come back in sixteenths of a coefficient's unit

    explicit CosineTransform(int length);    ///< 1 .. kMaxLength
    int length() const { return length_; }

    /// samples[t] = sum_f C(t, f) coefficients[f], in sixteenths, halves up.
    void inverse(const std::int32_t* coefficients, std::int64_t* samples) const;
    /// coefficients[f] = sum_t C(t, f) samples[t]: the encoder's side, in floating point.
    void forward(const double* samples, double* coefficients) const;

    /// The transform of this length; made once, kept for the process.
    static const CosineTransform& of(int length);

private:
    static constexpr int kScaleBits = 20;
    int length_;
    std::vector<std::int32_t> table_;  ///< length x length, row t, in 2^-kScaleBits
};

}  // namespace mien::coding
