#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "coding/integer_binarisation.hpp"
#include "coding/range_coder.hpp"

namespace mien::coding {

/// ln(p / (1 - p)) in 1/256, clamped to +-kMaxLogit, and its inverse. Tables of integers.
inline constexpr int kMaxLogit = 2815;  // p down to 1.1 / 65536
struct LogitTables {
    std::array<std::int16_t, 4096> logit;                       ///< of (i + 1/2) / 4096
    std::array<std::uint16_t, 2 * kMaxLogit + 1> logistic;      ///< of i - kMaxLogit

    static const LogitTables& get();
};
int logit(Probability p);
Probability logistic(int logit);

/// The chance of a set bit in one context, learnt by counting: the n-th update moves by 1 / (n + 1.5) of the difference,
/// until `limit` makes it a leaky average.
struct AdaptiveBit {
    static constexpr int kRates = 1024;   ///< limits are below

    std::uint16_t p = kHalf;
    std::uint16_t n = 0;

    void update(int bit, int limit) {
        // The difference to 65535 or 0, times a rate below 1, rounded down: all in 32 bits, as neither is above 65535.
        const std::uint32_t rate = kRate[n], now = p;
        if (bit) {
            p = std::uint16_t(now + ((65535 - now) * rate >> 16));
        } else {
            const std::uint32_t less = (now * rate + 65535) >> 16;
            p = std::uint16_t(now - less + (now == less));
        }
        n = std::uint16_t(n + (n < limit));
    }

    template <class Coder>
    void code(Coder& coder, int& bit, int limit = 60) {
        coder.code(bit, p < 32 ? 32u : p > 65536 - 32 ? 65536u - 32 : p);
        update(bit, limit);
    }

private:
    static constexpr std::array<std::uint32_t, kRates> kRate = [] {
        std::array<std::uint32_t, kRates> rate{};
        for (std::uint32_t seen = 0; seen < kRates; ++seen) rate[seen] = 2 * 65536 / (2 * seen + 3);
        return rate;
    }();
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
        const Rows rows = rows_of(contexts);
        code_integer(
            coder, value,
            [&](int& bit, int bin) { code_bin(coder, bit, contexts.shifted ? Binarisation::shifted_bin(bin) : bin, rows); },
            [&](int& bit) { signs_[std::size_t(contexts.sign)].code(coder, bit, limit_); });
    }

    /// A yes or no, as the zero flag of an integer would be.
    template <class Coder>
    void code_flag(Coder& coder, int& flag, const Contexts& contexts) {
        code_bin(coder, flag, 0, rows_of(contexts));
    }

    /// Bits that `value` would cost now; nothing is learnt.
    double cost(std::int32_t value, const Contexts& contexts) const;

    /// From here on what is learnt is also kept in mind, until take_back() undoes it: for an encoder that tries things.
    void begin_trial() {
        watched_ = trying_ = true;
        signs_before_ = signs_;
    }
    void take_back();

    /// All adaptive state, in a fixed order, so that a start can be stored.
    std::span<AdaptiveBit> bits() { return bits_; }        ///< input-major, then context, then bin
    std::span<AdaptiveBit> signs() { return signs_; }
    /// Mixer sets x bins x inputs, 1 = 65536.
    std::int32_t& weight(std::size_t i) { return weights_[i / std::size_t(inputs_) * kLanes + i % std::size_t(inputs_)]; }
    std::size_t weight_count() const { return weights_.size() / kLanes * std::size_t(inputs_); }
    int inputs() const { return inputs_; }
    /// Zeros and ones seen per entry of bits() since start_counting(): for training a start.
    void start_counting() {
        seen_.assign(bits_.size() * 2, 0);
        watched_ = true;
    }
    std::span<const std::uint32_t> seen() const { return seen_; }

    /// Learns without the processor's vector instructions, which make the same numbers.
    void use_plain() { learn_ = nullptr; }

private:
    static constexpr std::size_t kLanes = 8;         ///< room for the weights of a decision, of which only those of inputs are not zero
    static constexpr std::size_t kWorthVectors = 4;  ///< inputs from which vectors are the faster way

    /// Where the first bin of each of an integer's contexts lies.
    struct Rows {
        std::array<std::uint32_t, kMaxInputs> at;
        std::uint32_t weights;
    };
    struct Mixed {
        std::array<std::uint32_t, kMaxInputs> at;
        std::array<std::int32_t, kMaxInputs> logits;
        std::size_t weights;
        Probability p;
    };

    static constexpr std::int32_t kMaxWeight = 1 << 20;
    static Probability bounded(Probability p) { return std::clamp<Probability>(p, 24, 65536 - 24); }

    // How many inputs there are is known to the compiler where it counts: their loops unroll, and their numbers stay in registers.
    template <class Work>
    decltype(auto) with_inputs(Work&& work) const {
        switch (inputs_) {
            case 1: return work(std::integral_constant<std::size_t, 1>());
            case 2: return work(std::integral_constant<std::size_t, 2>());
            case 3: return work(std::integral_constant<std::size_t, 3>());
            case 4: return work(std::integral_constant<std::size_t, 4>());
            case 5: return work(std::integral_constant<std::size_t, 5>());
            case 6: return work(std::integral_constant<std::size_t, 6>());
            default: return work(std::integral_constant<std::size_t, kMaxInputs>());
        }
    }

    Rows rows_of(const Contexts& contexts) const {
        Rows rows;
        with_inputs([&](auto inputs) {
            for (std::size_t i = 0; i < inputs; ++i) {
                assert(contexts.input[i] >= 0 && contexts.input[i] < counts_[i]);
                rows.at[i] = first_[i] + std::uint32_t(contexts.input[i]) * std::uint32_t(bins_);
            }
        });
        rows.weights = std::uint32_t(contexts.mixer) * std::uint32_t(bins_);
        return rows;
    }

    template <class Coder>
    void code_bin(Coder& coder, int& bit, int bin, const Rows& rows) {
        with_inputs([&](auto inputs) {
            Mixed mixed;
            predict<inputs>(mixed, bin, rows);
            coder.code(bit, mixed.p);
            if (watched_) watch(mixed, bit);
            if (inputs >= kWorthVectors && learn_)
                learn_(mixed, error(mixed, bit), bit, limit_, weights_.data() + mixed.weights, bits_.data());
            else
                learn<inputs>(mixed, bit);
        });
    }

    template <std::size_t kInputs>
    void predict(Mixed& mixed, int bin, const Rows& rows) const {
        assert(std::size_t(bin) < bins_);
        mixed.weights = (rows.weights + std::uint32_t(bin)) * kLanes;
        const std::int32_t* weights = weights_.data() + mixed.weights;
        const AdaptiveBit* bits = bits_.data();
        std::int64_t sum = 0;
        for (std::size_t i = 0; i < kInputs; ++i) {
            mixed.at[i] = rows.at[i] + std::uint32_t(bin);
            mixed.logits[i] = tables_->logit[bits[mixed.at[i]].p >> 4];
            sum += std::int64_t(weights[i]) * mixed.logits[i];
        }
        const int mean = int(std::clamp<std::int64_t>(sum >> 16, -kMaxLogit, kMaxLogit));
        mixed.p = bounded(tables_->logistic[std::size_t(mean + kMaxLogit)]);
    }

    // |error| < 2^16, |logits| < 2^12: five times their product stays below 2^31.
    static std::int32_t error(const Mixed& mixed, int bit) { return 5 * ((bit ? 65536 : 0) - std::int32_t(mixed.p)); }

    template <std::size_t kInputs>
    void learn(const Mixed& mixed, int bit) {
        std::int32_t* weights = weights_.data() + mixed.weights;
        AdaptiveBit* bits = bits_.data();
        for (std::size_t i = 0; i < kInputs; ++i)
            weights[i] = std::clamp<std::int32_t>(weights[i] + (error(mixed, bit) * mixed.logits[i] >> 16), -kMaxWeight, kMaxWeight);
        for (std::size_t i = 0; i < kInputs; ++i) bits[mixed.at[i]].update(bit, limit_);
    }

    /// Notes what learn() is about to change, for take_back() and seen().
    void watch(const Mixed& mixed, int bit);

    /// learn() for many inputs: error as error() has it, then what changes.
    using Learn = void (*)(const Mixed& mixed, std::int32_t error, int bit, int limit, std::int32_t* weights, AdaptiveBit* bits);
    template <std::size_t kInputs>
    static void learn_avx2(const Mixed& mixed, std::int32_t error, int bit, int limit, std::int32_t* weights, AdaptiveBit* bits);
    static Learn fastest_learn(int inputs);

    const LogitTables* tables_ = &LogitTables::get();
    Learn learn_ = nullptr;   ///< none: learn()
    int inputs_ = 0;
    int limit_;
    std::size_t bins_;
    std::vector<int> counts_;
    std::array<std::uint32_t, kMaxInputs> first_{};  ///< of each input in bits_
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
    bool watched_ = false, trying_ = false;
    std::vector<Learnt> learnt_;         ///< during a trial
    std::vector<AdaptiveBit> signs_before_;
};

/// 0, 1, 2, 3-4, 5-8, 9-16, ...: magnitudes in `levels` steps.
inline int magnitude_level(std::uint32_t magnitude, int levels) {
    const int level = magnitude < 3 ? int(magnitude) : 33 - __builtin_clz(magnitude - 1);
    return level < levels ? level : levels - 1;
}

}  // namespace mien::coding
