#include "coding/integer_model.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

namespace mien::coding {
namespace {

// Rounded to integers, these do not depend on the last digits of anyone's exp or log: the test measures how far every
// entry is from a tie.
struct Tables {
    std::array<std::int16_t, 4096> logit;
    std::array<std::uint16_t, 2 * kMaxLogit + 1> logistic;
    Tables() {
        for (int i = 0; i < 4096; ++i) {
            const double p = (i + 0.5) / 4096;
            logit[std::size_t(i)] = std::int16_t(std::lround(256 * std::log(p / (1 - p))));
        }
        for (int d = -kMaxLogit; d <= kMaxLogit; ++d) {
            const long p = std::lround(65536 / (1 + std::exp(-d / 256.0)));
            logistic[std::size_t(d + kMaxLogit)] = std::uint16_t(std::clamp(p, 1l, 65535l));
        }
    }
};
const Tables& tables() {
    static const Tables tables;
    return tables;
}

constexpr int kRates = 1024;
constexpr std::array<std::uint32_t, kRates> kRate = [] {
    std::array<std::uint32_t, kRates> rate{};
    for (int n = 0; n < kRates; ++n) rate[std::size_t(n)] = std::uint32_t(2 * 65536 / (2 * n + 3));
    return rate;
}();

Probability bounded(Probability p) { return std::clamp<Probability>(p, 24, 65536 - 24); }

}  // namespace

int logit(Probability p) { return tables().logit[p >> 4]; }
Probability logistic(int value) {
    return tables().logistic[std::size_t(std::clamp(value, -kMaxLogit, kMaxLogit) + kMaxLogit)];
}

void AdaptiveBit::update(int bit, int limit) {
    const std::int64_t target = bit ? 65535 : 0;
    const std::int64_t moved = p + ((target - p) * kRate[n] >> 16);
    p = std::uint16_t(std::clamp<std::int64_t>(moved, 1, 65535));
    if (n < limit) ++n;
}

IntegerModel::IntegerModel(std::span<const int> context_counts, int mixer_sets, int sign_contexts, int limit, int bins)
    : inputs_(int(context_counts.size())), limit_(limit), bins_(std::size_t(bins)), counts_(context_counts.begin(), context_counts.end()) {
    assert(inputs_ <= kMaxInputs && limit < kRates);
    std::size_t total = 0;
    for (int count : counts_) {
        first_.push_back(total);
        total += std::size_t(count) * bins_;
    }
    bits_.resize(total);
    signs_.resize(std::size_t(sign_contexts));
    weights_.assign(std::size_t(mixer_sets) * bins_ * std::size_t(inputs_), 65536 * 4 / (inputs_ * 3));
}

IntegerModel::Mixed IntegerModel::predict(int bin, const Contexts& contexts) const {
    assert(std::size_t(bin) < bins_);
    Mixed mixed;
    mixed.weights = (std::size_t(contexts.mixer) * bins_ + std::size_t(bin)) * std::size_t(inputs_);
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < std::size_t(inputs_); ++i) {
        assert(contexts.input[i] >= 0 && contexts.input[i] < counts_[i]);
        mixed.at[i] = std::uint32_t(first_[i] + std::size_t(contexts.input[i]) * bins_ + std::size_t(bin));
        mixed.logits[i] = logit(bits_[mixed.at[i]].p);
        sum += std::int64_t(weights_[mixed.weights + i]) * mixed.logits[i];
    }
    mixed.p = bounded(logistic(int(std::clamp<std::int64_t>(sum >> 16, -kMaxLogit, kMaxLogit))));
    return mixed;
}

void IntegerModel::learn(const Mixed& mixed, int bit) {
    const std::int64_t error = (bit ? 65536 : 0) - std::int64_t(mixed.p);
    for (std::size_t i = 0; i < std::size_t(inputs_); ++i) {
        std::int32_t& weight = weights_[mixed.weights + i];
        if (trying_) learnt_.push_back({mixed.at[i], std::uint32_t(mixed.weights + i), weight, bits_[mixed.at[i]], bit != 0});
        const std::int64_t moved = weight + (error * mixed.logits[i] * 5 >> 16);
        weight = std::int32_t(std::clamp<std::int64_t>(moved, -(1 << 20), 1 << 20));
        if (!seen_.empty()) ++seen_[std::size_t(mixed.at[i]) * 2 + std::size_t(bit)];
        bits_[mixed.at[i]].update(bit, limit_);
    }
}

void IntegerModel::take_back() {
    for (std::size_t i = learnt_.size(); i-- > 0;) {
        const Learnt& learnt = learnt_[i];
        weights_[learnt.weight_at] = learnt.weight;
        bits_[learnt.at] = learnt.bit;
        if (!seen_.empty()) --seen_[std::size_t(learnt.at) * 2 + std::size_t(learnt.set)];
    }
    learnt_.clear();
    signs_ = signs_before_;
    trying_ = false;
}

double IntegerModel::cost(std::int32_t value, const Contexts& contexts) const {
    CostCoder coder;
    code_integer(
        coder, value, [&](int& bit, int bin) { coder.code(bit, predict(contexts.shifted ? Binarisation::shifted_bin(bin) : bin, contexts).p); },
        [&](int& bit) { coder.code(bit, bounded(signs_[std::size_t(contexts.sign)].p)); });
    return coder.bits();
}

}  // namespace mien::coding
