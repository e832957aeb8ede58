#include "coding/range_coder.hpp"

#include <gtest/gtest.h>

#include <random>

namespace mien::coding {
namespace {

struct Decision {
    int bit;
    Probability set;
};

std::vector<Decision> decisions(unsigned seed, int count) {
    std::mt19937 random(seed);
    std::vector<Decision> out;
    for (int i = 0; i < count; ++i) {
        const Probability set = random() % 4 == 0 ? (random() % 2 ? 1u : 65535u) : 1 + random() % 65535;
        out.push_back({int(random() % 65536 < set), set});
    }
    return out;
}

Bytes encode(const std::vector<Decision>& list, std::uint64_t* digest = nullptr) {
    RangeEncoder encoder;
    for (Decision d : list) encoder.code(d.bit, d.set);
    if (digest) *digest = encoder.digest();
    return encoder.finish();
}

TEST(RangeCoder, BringsBackEveryDecisionAndTheSameState) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        const auto list = decisions(seed, int(seed * 7));
        std::uint64_t digest = 0;
        const Bytes bytes = encode(list, &digest);
        RangeDecoder decoder(bytes);
        for (const Decision& d : list) {
            int bit = -1;
            decoder.code(bit, d.set);
            ASSERT_EQ(bit, d.bit);
        }
        EXPECT_TRUE(decoder.complete());
        EXPECT_EQ(decoder.digest(), digest);
    }
}

TEST(RangeCoder, CodesNothingInNoBytes) { EXPECT_TRUE(encode({}).empty()); }

TEST(RangeCoder, CodesAFewLikelyDecisionsInOneByteAtMost) {
    const std::vector<Decision> list(20, Decision{0, 400});
    EXPECT_LE(encode(list).size(), 1u);
}

TEST(RangeCoder, IsUsedUpAfterABoundedNumberOfDecisionsWhateverTheBytes) {
    std::mt19937 random(31);
    for (std::size_t size = 0; size < 30; ++size) {
        Bytes bytes(size);
        for (std::byte& b : bytes) b = size % 3 == 0 ? std::byte(0xff * (random() % 2)) : std::byte(random());
        RangeDecoder decoder(bytes);
        std::uint64_t decisions = 0;
        for (const std::uint64_t most = most_decisions(size); !decoder.failed() && decisions <= most; ++decisions) {
            // Always the surest chance that comes true: no model can make the bytes last longer.
            int bit = 0;
            RangeDecoder ahead = decoder;
            ahead.code(bit, 65536 - kLeastChance);
            decoder.code(bit, bit ? 65536 - kLeastChance : kLeastChance);
        }
        EXPECT_LE(decisions, most_decisions(size)) << size;
        EXPECT_GT(decisions + decisions / 20, most_decisions(size)) << size << ": the bound is loose";
    }
}

TEST(RangeCoder, NoticesMissingAndSpareBytes) {
    const auto list = decisions(3, 3000);
    Bytes bytes = encode(list);
    const auto complete = [&](ByteView view) {
        RangeDecoder decoder(view);
        for (const Decision& d : list) {
            int bit = 0;
            decoder.code(bit, d.set);
        }
        return decoder.complete();
    };
    EXPECT_TRUE(complete(bytes));
    EXPECT_FALSE(complete(ByteView(bytes).first(bytes.size() - 5)));
    bytes.resize(bytes.size() + 5);
    EXPECT_FALSE(complete(bytes));
}

}  // namespace
}  // namespace mien::coding
