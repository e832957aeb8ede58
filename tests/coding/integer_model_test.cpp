#include "coding/integer_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace mien::coding {
namespace {

constexpr std::array<int, 2> kContexts{4, 3};

TEST(IntegerModel, BringsBackIntegersOfEverySize) {
    std::mt19937 random(5);
    std::vector<std::int32_t> values{0, 1, -1, 2, -2, Binarisation::kMaxMagnitude, -Binarisation::kMaxMagnitude};
    for (int i = 0; i < 3000; ++i) values.push_back((random() % 2 ? 1 : -1) * std::int32_t(random() >> (5 + random() % 27)));
    IntegerModel writer(kContexts, 1, 2, 100), reader = writer;
    const auto contexts = [](std::size_t i) {
        IntegerModel::Contexts c;
        c.input = {int(i % 4), int(i % 3)};
        c.sign = int(i % 2);
        return c;
    };
    RangeEncoder encoder;
    for (std::size_t i = 0; i < values.size(); ++i) writer.code(encoder, values[i], contexts(i));
    const std::uint64_t digest = encoder.digest();
    const Bytes bytes = encoder.finish();
    RangeDecoder decoder(bytes);
    for (std::size_t i = 0; i < values.size(); ++i) {
        std::int32_t value = 12345;
        reader.code(decoder, value, contexts(i));
        ASSERT_EQ(value, values[i]) << i;
    }
    EXPECT_TRUE(decoder.complete());
    EXPECT_EQ(decoder.digest(), digest);
}

TEST(IntegerModel, LearnsAGeometricSourceToNearItsEntropy) {
    std::mt19937 random(9);
    IntegerModel model(kContexts, 1, 2, 500);
    RangeEncoder encoder;
    double entropy = 0;
    constexpr int count = 20000;
    for (int i = 0; i < count; ++i) {
        std::int32_t v = 0;
        while (random() % 8 >= 5) ++v;               // P(v) = (5/8) (3/8)^v
        entropy -= std::log2(0.625) + v * std::log2(0.375);
        if (v > 0 && random() % 2) v = -v;
        if (v != 0) entropy += 1;
        model.code(encoder, v, {});
    }
    EXPECT_LT(8.0 * double(encoder.finish().size()), entropy * 1.02);
}

TEST(IntegerModel, CostForeseesWhatCodingSpends) {
    IntegerModel model(kContexts, 1, 2, 100);
    for (std::int32_t v : {0, 3, -7, 0, 0, 100, -1, 1, 0}) {
        const double foreseen = model.cost(v, {});
        CostCoder coder;
        model.code(coder, v, {});
        EXPECT_NEAR(foreseen, coder.bits(), 1e-6);
    }
}

/// What IntegerModel does, written down as its definition has it, in 64 bits and without a thought for speed.
struct PlainModel {
    explicit PlainModel(std::span<const int> counts, int most) : limit(most), weights(Binarisation::kBins * counts.size(), 65536 * 4 / (int(counts.size()) * 3)) {
        for (const int count : counts) chances.emplace_back(std::size_t(count) * Binarisation::kBins);
    }
    struct Chance {
        std::int64_t p = 32768, n = 0;
    };
    Probability code(int bit, int bin, const IntegerModel::Contexts& contexts) {
        std::int64_t sum = 0;
        std::vector<std::int64_t> logits;
        std::int64_t* weight = weights.data() + std::size_t(bin) * chances.size();
        for (std::size_t i = 0; i < chances.size(); ++i) {
            logits.push_back(logit(Probability(at(i, bin, contexts).p)));
            sum += weight[i] * logits.back();
        }
        const std::int64_t p = std::clamp<std::int64_t>(logistic(int(std::clamp<std::int64_t>(sum >> 16, -kMaxLogit, kMaxLogit))), 24, 65536 - 24);
        const std::int64_t error = (bit ? 65536 : 0) - p;
        for (std::size_t i = 0; i < chances.size(); ++i) {
            weight[i] = std::clamp<std::int64_t>(weight[i] + (error * logits[i] * 5 >> 16), -(1 << 20), 1 << 20);
            Chance& chance = at(i, bin, contexts);
            chance.p = std::clamp<std::int64_t>(chance.p + (((bit ? 65535 : 0) - chance.p) * (2 * 65536 / (2 * chance.n + 3)) >> 16), 1, 65535);
            chance.n = std::min<std::int64_t>(chance.n + 1, limit);
        }
        return Probability(p);
    }
    Chance& at(std::size_t input, int bin, const IntegerModel::Contexts& contexts) {
        return chances[input][std::size_t(contexts.input[input]) * Binarisation::kBins + std::size_t(bin)];
    }
    std::int64_t limit;
    std::vector<std::vector<Chance>> chances;
    std::vector<std::int64_t> weights;
};

/// Notes the chances it is given, and codes nothing.
struct ChanceCoder {
    static constexpr bool kDecodes = false;
    void code(int&, Probability set) { last = set; }
    bool failed() const { return false; }
    void fail() {}
    Probability last = 0;
};

TEST(IntegerModel, GivesTheChancesOfItsPlainDefinitionForAnyNumberOfInputs) {
    for (int inputs = 1; inputs <= IntegerModel::kMaxInputs; ++inputs) {
        const std::vector<int> counts(std::size_t(inputs), 5);
        constexpr int limit = 1000;   // every rate there is
        IntegerModel fast(counts, 1, 1, limit), scalar(counts, 1, 1, limit);
        scalar.use_plain();
        PlainModel plain(counts, limit);
        std::mt19937 random{unsigned(inputs)};
        ChanceCoder coder;
        for (int i = 0; i < 30000; ++i) {
            IntegerModel::Contexts contexts;
            for (int c = 0; c < inputs; ++c) contexts.input[std::size_t(c)] = int(random() % 5);
            // Long runs bring chances and weights to their ends.
            int flag = i / 3000 % 2 ? int(random() % 64 == 0) : int(random() % 5) < contexts.input[0];
            const Probability truth = plain.code(flag, 0, contexts);
            for (IntegerModel* model : {&fast, &scalar}) {
                model->code_flag(coder, flag, contexts);
                ASSERT_EQ(coder.last, truth) << inputs << " inputs, decision " << i << (model == &scalar ? ", scalar" : "");
            }
        }
    }
}

// The tables come from exp and log; none of their entries is so near a tie that another library could round it otherwise.
TEST(IntegerModel, TablesDoNotHangOnTheLastDigit) {
    for (int d = -kMaxLogit; d <= kMaxLogit; ++d) {
        if (d == 0) continue;
        const double exact = 65536 / (1 + std::exp(-d / 256.0));
        EXPECT_GT(std::abs(exact - std::floor(exact) - 0.5), 1e-7) << d;
    }
    for (int i = 0; i < 4096; ++i) {
        const double exact = 256 * std::log((i + 0.5) / (4095.5 - i));
        EXPECT_GT(std::abs(exact - std::floor(exact) - 0.5), 1e-7) << i;
    }
    for (Probability p = 1; p < 65536; p += 13) EXPECT_NEAR(double(logistic(logit(p))), double(p), 140) << p;
}

TEST(MagnitudeLevel, GrowsByOctaves) {
    const std::array<int, 12> want{0, 1, 2, 3, 3, 4, 4, 4, 4, 5, 5, 5};
    for (std::uint32_t m = 0; m < want.size(); ++m) EXPECT_EQ(magnitude_level(m, 20), want[m]) << m;
    EXPECT_EQ(magnitude_level(1u << 30, 8), 7);
}

}  // namespace
}  // namespace mien::coding
