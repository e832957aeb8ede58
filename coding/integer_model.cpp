#include "coding/integer_model.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdlib>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace mien::coding {
namespace {

// Rounded to integers, these do not depend on the last digits of anyone's exp or log: the test measures how far every
// entry is from a tie.
LogitTables make_tables() {
    LogitTables tables;
    for (int i = 0; i < 4096; ++i) {
        const double p = (i + 0.5) / 4096;
        tables.logit[std::size_t(i)] = std::int16_t(std::lround(256 * std::log(p / (1 - p))));
    }
    for (int d = -kMaxLogit; d <= kMaxLogit; ++d) {
        const long p = std::lround(65536 / (1 + std::exp(-d / 256.0)));
        tables.logistic[std::size_t(d + kMaxLogit)] = std::uint16_t(std::clamp(p, 1l, 65535l));
    }
    return tables;
}

}  // namespace

const LogitTables& LogitTables::get() {
    static const LogitTables tables = make_tables();
    return tables;
}

int logit(Probability p) { return LogitTables::get().logit[p >> 4]; }
Probability logistic(int value) {
    return LogitTables::get().logistic[std::size_t(std::clamp(value, -kMaxLogit, kMaxLogit) + kMaxLogit)];
}

IntegerModel::IntegerModel(std::span<const int> context_counts, int mixer_sets, int sign_contexts, int limit, int bins)
    : learn_(fastest_learn(int(context_counts.size()))), inputs_(int(context_counts.size())), limit_(limit), bins_(std::size_t(bins)), counts_(context_counts.begin(), context_counts.end()) {
    assert(inputs_ >= 1 && inputs_ <= kMaxInputs && limit < AdaptiveBit::kRates);
    std::size_t total = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
        first_[i] = std::uint32_t(total);
        total += std::size_t(counts_[i]) * bins_;
    }
    bits_.resize(total);
    signs_.resize(std::size_t(sign_contexts));
    weights_.assign(std::size_t(mixer_sets) * bins_ * kLanes, 0);
    for (std::size_t i = 0; i < weight_count(); ++i) weight(i) = 65536 * 4 / (inputs_ * 3);
}

#if defined(__x86_64__)
template <std::size_t kInputs>
[[gnu::target("avx2")]] void IntegerModel::learn_avx2(const Mixed& mixed, std::int32_t error, int bit, int limit, std::int32_t* weights, AdaptiveBit* bits) {
    static_assert(sizeof(AdaptiveBit) == sizeof(std::uint32_t) && std::endian::native == std::endian::little);
    // Lane by lane into registers: a vector load of numbers that were just stored one by one waits for all of these stores.
    const auto logit = [&](std::size_t i) { return i < kInputs ? mixed.logits[i] : 0; };
    const auto entry = [&](std::size_t i) { return i < kInputs ? std::bit_cast<std::int32_t>(bits[mixed.at[i]]) : 0; };
    const __m256i logits = _mm256_setr_epi32(logit(0), logit(1), logit(2), logit(3), logit(4), logit(5), logit(6), logit(7));
    const __m256i word = _mm256_setr_epi32(entry(0), entry(1), entry(2), entry(3), entry(4), entry(5), entry(6), entry(7));   // p below, n above

    const auto at_weights = reinterpret_cast<__m256i*>(weights);
    const __m256i change = _mm256_srai_epi32(_mm256_mullo_epi32(_mm256_set1_epi32(error), logits), 16);
    const __m256i moved = _mm256_add_epi32(_mm256_loadu_si256(at_weights), change);
    _mm256_storeu_si256(at_weights, _mm256_min_epi32(_mm256_max_epi32(moved, _mm256_set1_epi32(-kMaxWeight)), _mm256_set1_epi32(kMaxWeight)));

    // AdaptiveBit::update. The rate is 131072 / (2 n + 3) rounded down: the quotient of floats never rounds up to an integer,
    // as it is at least 1 / (2 n + 3) below one, 128 times its own rounding.
    const __m256i p = _mm256_and_si256(word, _mm256_set1_epi32(0xffff)), n = _mm256_srli_epi32(word, 16);
    const __m256i divisor = _mm256_add_epi32(_mm256_add_epi32(n, n), _mm256_set1_epi32(3));
    const __m256i rate = _mm256_cvttps_epi32(_mm256_div_ps(_mm256_set1_ps(131072), _mm256_cvtepi32_ps(divisor)));
    const __m256i flip = _mm256_set1_epi32(bit - 1), most = _mm256_set1_epi32(0xffff);   // flip: no bit of a one, all bits of a zero
    const __m256i distance = _mm256_xor_si256(p, _mm256_andnot_si256(flip, most));
    const __m256i step = _mm256_srli_epi32(_mm256_add_epi32(_mm256_mullo_epi32(distance, rate), _mm256_and_si256(flip, most)), 16);
    const __m256i next = _mm256_max_epi32(_mm256_add_epi32(p, _mm256_sub_epi32(_mm256_xor_si256(step, flip), flip)), _mm256_set1_epi32(1));
    const __m256i age = _mm256_sub_epi32(n, _mm256_cmpgt_epi32(_mm256_set1_epi32(limit), n));
    alignas(32) std::uint32_t words[kLanes];
    _mm256_store_si256(reinterpret_cast<__m256i*>(words), _mm256_or_si256(next, _mm256_slli_epi32(age, 16)));
    for (std::size_t i = 0; i < kInputs; ++i) bits[mixed.at[i]] = std::bit_cast<AdaptiveBit>(words[i]);
}

IntegerModel::Learn IntegerModel::fastest_learn(int inputs) {
    static const bool has = __builtin_cpu_supports("avx2");
    if (!has) return nullptr;
    switch (inputs) {
        case 4: return learn_avx2<4>;
        case 5: return learn_avx2<5>;
        case 6: return learn_avx2<6>;
        case 7: return learn_avx2<7>;
        default: return nullptr;
    }
}
#else
IntegerModel::Learn IntegerModel::fastest_learn(int) { return nullptr; }
#endif

void IntegerModel::watch(const Mixed& mixed, int bit) {
    for (std::size_t i = 0; i < std::size_t(inputs_); ++i) {
        if (trying_)
            learnt_.push_back({mixed.at[i], std::uint32_t(mixed.weights + i), weights_[mixed.weights + i], bits_[mixed.at[i]], bit != 0});
        if (!seen_.empty()) ++seen_[std::size_t(mixed.at[i]) * 2 + std::size_t(bit)];
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
    watched_ = !seen_.empty();
}

double IntegerModel::cost(std::int32_t value, const Contexts& contexts) const {
    CostCoder coder;
    const Rows rows = rows_of(contexts);
    code_integer(
        coder, value,
        [&](int& bit, int bin) {
            Mixed mixed;
            with_inputs([&](auto inputs) { predict<inputs>(mixed, contexts.shifted ? Binarisation::shifted_bin(bin) : bin, rows); });
            coder.code(bit, mixed.p);
        },
        [&](int& bit) { coder.code(bit, bounded(signs_[std::size_t(contexts.sign)].p)); });
    return coder.bits();
}

}  // namespace mien::coding
