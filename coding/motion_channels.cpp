#include "coding/motion_channels.hpp"

namespace mien::coding {
namespace {

// A representative of every level of magnitude_level() and fine_level(), in quarters.
std::uint32_t magnitude_of(int level) { return level < 3 ? std::uint32_t(4 * level) : 6u << (level - 2); }
std::uint32_t fine_magnitude_of(int level) {
    return level < 2 ? std::uint32_t(4 * level) : ((level & 1) ? 7u : 5u) << (level / 2);
}

// Of a number below 2^32: the square root, rounded down.
std::uint64_t root(std::uint64_t square) {
    std::uint64_t found = 0;
    for (std::uint64_t bit = 1u << 15; bit > 0; bit >>= 1)
        if ((found + bit) * (found + bit) <= square) found += bit;
    return found;
}

// Chances of every decision for a two-sided geometric number of mean magnitude `mean` / 256.
void expect(std::span<AdaptiveBit> bins, std::uint64_t mean) {
    constexpr int kConfidence = 5;
    const auto set = [&](int bin, std::uint64_t chance) {
        bins[std::size_t(bin)].p = std::uint16_t(std::clamp<std::uint64_t>(chance, 64, 65536 - 64));
        bins[std::size_t(bin)].n = kConfidence;
    };
    const std::uint64_t ratio = 65536 * mean / (mean + 256);
    set(0, ratio);
    std::uint64_t power = ratio;  // ratio ^ (2 ^ class)
    for (int cls = 0; cls < 10; ++cls) {
        set(Binarisation::class_bin(cls), power);
        // The upper half of class cls + 1 against the lower: ratio ^ (2 ^ cls) to 1.
        set(Binarisation::first_bit_bin(cls + 1), 65536 * power / (65536 + power));
        power = power * power >> 16;
    }
    if (bins.size() == Binarisation::kBins) return;
    // Shifted by half a step: zero reaches to a quarter of a step, one to a whole one.
    const std::uint64_t half = root(ratio << 16), quarter = root(half << 16);
    set(Binarisation::shifted_bin(0), half);
    set(Binarisation::shifted_bin(Binarisation::class_bin(0)), half * quarter >> 16);
    set(Binarisation::shifted_bin(Binarisation::class_bin(1)), ratio * ratio >> 16);
    set(Binarisation::shifted_bin(Binarisation::first_bit_bin(1)), 65536 * ratio / (65536 + ratio));
}

}  // namespace

IntegerModel MotionChannels::make_model() const {
    IntegerModel model(counts_, 1, 3, kLimit, int(bins()));
    std::span<AdaptiveBit> bits = model.bits();
    const auto next = [&] {
        const auto here = bits.first(bins());
        bits = bits.subspan(bins());
        return here;
    };
    for (int i = 0; i < kContexts[0]; ++i) next();
    for (int i = 0; i < kContexts[1]; ++i) {
        const auto bins = next();
        if (i % 8 == 0) continue;  // the first frequency has no neighbours below
        expect(bins, 20 + 64 * (2 * magnitude_of(i / 48) + magnitude_of(i / 8 % 6)) * 4 / 15);
    }
    for (int i = 0; i < kContexts[2]; ++i) expect(next(), 36 + 64 * magnitude_of(i / 24) * 3 / 25);
    for (int i = 0; i < kContexts[3]; ++i) expect(next(), 14 + 64 * fine_magnitude_of(i / 4) * 9 / 120);
    for (int i = 0; i < kContexts[4]; ++i) expect(next(), 24 + 64 * magnitude_of(i % 4) * 3 / 8);
    return model;
}

}  // namespace mien::coding
