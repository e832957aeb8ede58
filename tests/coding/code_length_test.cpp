#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

#include "coding/integer_model.hpp"

/// What the range coder writes against the log-loss of the model that drives it: -log2 of the very chances that it was given, summed in
/// double.
namespace mien::coding {
namespace {

constexpr double kTermination = 8;   // bits a packet may spend on ending at a whole byte
constexpr double kOverhead = 0.001;  // share that a range of as few as 24 bits may cost; 0.03 is what is promised

/// A range encoder beside its own log-loss.
class MeteredEncoder {
public:
    static constexpr bool kDecodes = false;
    void code(int& bit, Probability set) {
        encoder_.code(bit, set);
        ideal_ += code_length(bit, set);
    }
    bool failed() const { return false; }
    void fail() {}
    double ideal() const { return ideal_; }
    double finish() { return 8.0 * double(encoder_.finish().size()); }

private:
    RangeEncoder encoder_;
    double ideal_ = 0;
};

double uniform(std::mt19937& random) { return (double(random()) + 0.5) / 4294967296.0; }

struct Source {
    const char* name;
    std::function<std::int32_t(std::mt19937& random, int at)> draw;
};

std::int32_t rounded_laplace(std::mt19937& random, double scale, double middle) {
    const double size = -scale * std::log(uniform(random));
    return std::int32_t(std::lround(middle + (random() % 2 ? size : -size)));
}

std::vector<Source> sources() {
    std::vector<Source> all;
    for (const double scale : {0.2, 1.0, 8.0, 300.0, 20000.0})
        all.push_back({"geometric", [=](std::mt19937& random, int) { return std::int32_t(-scale * std::log(uniform(random))); }});
    all.push_back({"drifting Laplace", [](std::mt19937& random, int at) {
                       return rounded_laplace(random, std::exp(3 + 2 * std::sin(0.002 * at)), 40 * std::sin(0.0007 * at));
                   }});
    all.push_back({"sparse", [](std::mt19937& random, int) { return random() % 500 ? 0 : std::int32_t(random() % 200) - 100; }});
    all.push_back({"uniform", [](std::mt19937& random, int) { return std::int32_t(random() % 2001) - 1000; }});
    return all;
}

// Numbers see how large and of which sign the last ones were, as the coders of motion do.
IntegerModel::Contexts contexts_after(std::int32_t last, std::int32_t before) {
    IntegerModel::Contexts contexts;
    contexts.input = {magnitude_level(std::uint32_t(std::abs(last)), 12), magnitude_level(std::uint32_t(std::abs(before)), 12)};
    contexts.sign = last > 0 ? 2 : last < 0 ? 0 : 1;
    return contexts;
}

TEST(CodeLength, OfAdaptivelyCodedIntegersIsTheModelsLogLoss) {
    constexpr std::array<int, 2> kContexts{12, 12};
    for (const Source& source : sources())
        for (const int packet : {1 << 20, 40}) {   // numbers per packet: one long run, and what a live frame holds
            std::mt19937 random(11);
            IntegerModel model(kContexts, 1, 3, 200);
            double real = 0, ideal = 0;
            std::int32_t last = 0, before = 0;
            constexpr int kNumbers = 12000;
            for (int i = 0; i < kNumbers;) {
                MeteredEncoder encoder;
                for (const int end = std::min(kNumbers, i + packet); i < end; ++i) {
                    std::int32_t value = source.draw(random, i);
                    model.code(encoder, value, contexts_after(last, before));
                    before = last;
                    last = value;
                }
                const double bits = encoder.finish();
                EXPECT_LE(bits, encoder.ideal() * (1 + kOverhead) + kTermination) << source.name << ", ends at " << i;
                real += bits;
                ideal += encoder.ideal();
            }
            // Nothing is coded in less than it is worth, or it would not come back.
            EXPECT_GE(real, ideal - 16) << source.name;
        }
}

TEST(CodeLength, OfSkewedDecisionsIsTheirLogLoss) {
    std::mt19937 random(7);
    MeteredEncoder encoder;
    for (int i = 0; i < 20000; ++i) {
        const Probability set = random() % 4 == 0 ? (random() % 2 ? 1u : 65535u) : 1 + random() % 65535;
        int bit = int(random() % 65536 < set);
        encoder.code(bit, set);
    }
    const double real = encoder.finish();
    EXPECT_LE(real, encoder.ideal() * (1 + kOverhead) + kTermination);
    EXPECT_GE(real, encoder.ideal() - 16);
}

TEST(CodeLength, OfAPacketsEndIsAByteAtMostAndHalfOfOneOnAverage) {
    std::mt19937 random(13);
    double termination = 0, most = 0;
    constexpr int kPackets = 4000;
    for (int p = 0; p < kPackets; ++p) {
        MeteredEncoder encoder;
        const int decisions = 1 + int(random() % 300);
        for (int i = 0; i < decisions; ++i) {
            const Probability set = 24 + random() % (65536 - 48);
            int bit = int(random() % 65536 < set);
            encoder.code(bit, set);
        }
        const double spent = encoder.finish() - encoder.ideal();
        EXPECT_LE(spent, kTermination + kOverhead * encoder.ideal());
        termination += spent / kPackets;
        most = std::max(most, spent);
    }
    std::printf("termination of %d packets: %.2f bits on average, %.2f at most\n", kPackets, termination, most);
    RecordProperty("mean_termination_bits", std::to_string(termination));
    EXPECT_LE(termination, kTermination / 2);
    EXPECT_GE(termination, 0);
}

}  // namespace
}  // namespace mien::coding
