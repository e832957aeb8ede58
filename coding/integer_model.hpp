#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coding/integer_binarisation.hpp"
#include "coding/range_coder.hpp"

namespace mien::coding {

/// ln(p / (1 - p)) in 1/256, clamped to +-kMaxLogit, and its inverse. Tables of integers.
inline constexpr int kMaxLogit = 2815;  // p down to 1.1 / 65536
int logit(Probability p);
Probability logistic(int logit);

/// The chance of a set bit in one context, learnt by counting: the n-th update moves by 1 / (n + 1.5) of the difference,
/// until `limit` makes it a leaky average.
struct AdaptiveBit {
    std::uint16_t p = kHalf;
    std::uint16_t n = 0;

    void update(int bit, int limit);

    template <class Coder>
    void code(Coder& coder, int& bit, int limit = 60) {
        coder.code(bit, p < 32 ? 32u : p > 65536 - 32 ? 65536u - 32 : p);
        update(bit, limit);
    }
};

/// Codes signed integers in several contexts at once: every context predicts each binary decision, and a small logistic
/// mixer that learns who is right combines them (Mahoney 2005, "Adaptive weighing of context models for lossless data
/// compression"). Integer only.
class IntegerModel {
public:
    static constexpr int kMaxInputs = 7;

    /// context_counts: how many values each context takes. mixer_sets: values of the context that selects mixer weights.
    /// bins: Binarisation::kBins, and kShiftedBins more where contexts may say `shifted`.
    IntegerModel(std::span<const int> context_counts, int mixer_sets, int sign_contexts, int limit, int bins = Binarisation::kBins);

    struct Contexts {
        std::array<int, kMaxInputs> input{};
        int mixer = 0;
        int sign = 0;
        bool shifted = false;   ///< the number is one of a quantiser that is shifted by half a step
        bool operator==(const Contexts&) const = default;
    };

    template <class Coder>
    void code(Coder& coder, std::int32_t& value, const Contexts& contexts) {
        code_integer(
            coder, value,
            [&](int& bit, int bin) {
                const Mixed mixed = predict(contexts.shifted ? Binarisation::shifted_bin(bin) : bin, contexts);
                coder.code(bit, mixed.p);
                learn(mixed, bit);
            },
            [&](int& bit) { signs_[std::size_t(contexts.sign)].code(coder, bit, limit_); });
    }

    /// A yes or no, as the zero flag of an integer would be.
    template <class Coder>
    void code_flag(Coder& coder, int& flag, const Contexts& contexts) {
        const Mixed mixed = predict(0, contexts);
        coder.code(flag, mixed.p);
        learn(mixed, flag);
    }

    /// Bits that `value` would cost now; nothing is learnt.
    double cost(std::int32_t value, const Contexts& contexts) const;

    /// From here on what is learnt is also kept in mind, until take_back() undoes it: for an encoder that tries things.
    void begin_trial() {
        trying_ = true;
        signs_before_ = signs_;
    }
    void take_back();

    /// All adaptive state, in a fixed order, so that a start can be stored.
    std::span<AdaptiveBit> bits() { return bits_; }        ///< input-major, then context, then bin
    std::span<AdaptiveBit> signs() { return signs_; }
    std::span<std::int32_t> weights() { return weights_; }  ///< mixer sets x bins x inputs, 1 = 65536
    int inputs() const { return inputs_; }
    /// Zeros and ones seen per entry of bits() since start_counting(): for training a start.
    void start_counting() { seen_.assign(bits_.size() * 2, 0); }
    std::span<const std::uint32_t> seen() const { return seen_; }

private:
    struct Mixed {
        std::array<std::uint32_t, kMaxInputs> at;
        std::array<int, kMaxInputs> logits;
        std::size_t weights;
        Probability p;
    };
    Mixed predict(int bin, const Contexts& contexts) const;
    void learn(const Mixed& mixed, int bit);

    int inputs_ = 0;
    int limit_;
    std::size_t bins_;
    std::vector<int> counts_;
    std::vector<std::size_t> first_;  ///< of each input in bits_
    std::vector<AdaptiveBit> bits_;
    std::vector<AdaptiveBit> signs_;
    std::vector<std::int32_t> weights_;
    std::vector<std::uint32_t> seen_;
    struct Learnt {
        std::uint32_t at, weight_at;
        std::int32_t weight;
        AdaptiveBit bit;
        bool set;
    };
    bool trying_ = false;
    std::vector<Learnt> learnt_;         ///< during a trial
    std::vector<AdaptiveBit> signs_before_;
};

/// 0, 1, 2, 3-4, 5-8, 9-16, ...: magnitudes in `levels` steps.
inline int magnitude_level(std::uint32_t magnitude, int levels) {
    const int level = magnitude < 3 ? int(magnitude) : 33 - __builtin_clz(magnitude - 1);
    return level < levels ? level : levels - 1;
}

}  // namespace mien::coding
