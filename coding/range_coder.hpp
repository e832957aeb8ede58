#pragma once

#include <cmath>
#include <cstdint>

#include "core/hash.hpp"

namespace mien::coding {

/// Probabilities of a set bit are sixteenths of 2^12: 1 .. 65535 of 65536.
using Probability = std::uint32_t;
inline constexpr int kProbabilityBits = 16;
inline constexpr Probability kHalf = 1u << (kProbabilityBits - 1);

/// No model of a motion stream gives a chance nearer to 0 or 65536 than this, whatever it has learnt or was told: static codes
/// come nearest (logistic(-2048)), adaptive bits stop at 32 and mixed ones at 24.
inline constexpr Probability kLeastChance = 22;
/// The most decisions that a run of so many bytes can hold when all their chances keep to kLeastChance, and the most a RangeDecoder
/// takes before failed() tells that its bytes are used up: a decision narrows the range by at least log2(65536 / (65536 - 22)) =
/// 1 / 2065 bit, and 8 bits a byte, with 8 more for a range between 2^24 and 2^32, are all there are.
constexpr std::uint64_t most_decisions(std::uint64_t bytes) { return 8 * 2065 * (bytes + 1) + 1; }

/// A running digest of everything a coder has seen: equal on both sides after every object, or something has drifted.
class StateDigest {
public:
    void add(std::uint64_t word) {
        value_ = (value_ ^ word) * 0x100000001b3ull;
        value_ ^= value_ >> 29;
    }
    std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 0xcbf29ce484222325ull;
};

/// Binary arithmetic encoder (a range coder with carry, after Martin 1979). An object ends with as few bytes as single it
/// out; the reader knows its length from outside and sees zeros behind it.
class RangeEncoder {
public:
    static constexpr bool kDecodes = false;

    void code(int& bit, Probability set) {
        const std::uint32_t bound = static_cast<std::uint32_t>(std::uint64_t(range_) * set >> kProbabilityBits);
        digest_.add(std::uint64_t(range_) << 20 ^ std::uint64_t(set) << 1 ^ unsigned(bit));
        if (bit) {
            range_ = bound;
        } else {
            low_ += bound;
            range_ -= bound;
        }
        while (range_ < (1u << 24)) {
            emit();
            range_ <<= 8;
        }
    }
    bool failed() const { return false; }
    void fail() {}

    /// Ends the object and returns its bytes; the encoder may not be used afterwards.
    Bytes finish() {
        // The value with the most trailing zero bytes in [low, low + range).
        int keep = 4;
        std::uint64_t value = low_;
        for (int bytes = 0; bytes < 4; ++bytes) {
            const std::uint64_t unit = std::uint64_t(1) << (32 - 8 * bytes);
            const std::uint64_t up = (low_ + unit - 1) / unit * unit;
            if (up < low_ + range_) {
                value = up;
                keep = bytes;
                break;
            }
        }
        low_ = value;
        if (keep == 0) carry();
        for (int i = 0; i < keep; ++i) emit();
        return std::move(bytes_);
    }
    std::uint64_t digest() const { return digest_.value(); }

private:
    void carry() {
        if (low_ >> 32) {
            for (std::size_t i = bytes_.size(); i-- > 0;) {
                bytes_[i] = static_cast<std::byte>(std::to_integer<unsigned>(bytes_[i]) + 1);
                if (bytes_[i] != std::byte{0}) break;
            }
            low_ &= 0xffffffffu;
        }
    }
    void emit() {
        carry();
        bytes_.push_back(static_cast<std::byte>(low_ >> 24));
        low_ = (low_ & 0xffffffu) << 8;
    }

    std::uint64_t low_ = 0;
    std::uint32_t range_ = 0xffffffffu;
    Bytes bytes_;
    StateDigest digest_;
};

/// What RangeEncoder wrote, back again. Behind the end it reads zeros; reading more of them than a well-formed object
/// needs, or leaving bytes unread, is an error that failed() and complete() tell. Never undefined, whatever the bytes.
class RangeDecoder {
public:
    static constexpr bool kDecodes = true;

    explicit RangeDecoder(ByteView bytes) : bytes_(bytes) {
        for (int i = 0; i < 4; ++i) next();
    }
    void code(int& bit, Probability set) {
        const std::uint32_t bound = static_cast<std::uint32_t>(std::uint64_t(range_) * set >> kProbabilityBits);
        const std::uint32_t before = range_;
        if (code_ < bound) {
            bit = 1;
            range_ = bound;
        } else {
            bit = 0;
            code_ -= bound;
            range_ -= bound;
        }
        digest_.add(std::uint64_t(before) << 20 ^ std::uint64_t(set) << 1 ^ unsigned(bit));
        while (range_ < (1u << 24)) {
            next();
            range_ <<= 8;
        }
    }
    void fail() { failed_ = true; }
    /// A value that cannot occur was met, or the object was shorter than what it announces.
    bool failed() const { return failed_ || at_ > bytes_.size() + 4; }
    /// Nothing failed and every byte was used.
    bool complete() const { return !failed() && at_ >= bytes_.size(); }
    std::uint64_t digest() const { return digest_.value(); }
    /// What all decisions so far have cost, bits.
    double cost() const { return 8 * double(at_) - std::log2(double(range_)); }

private:
    void next() {
        code_ = code_ << 8 | (at_ < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[at_]) : 0u);
        ++at_;
    }

    ByteView bytes_;
    std::size_t at_ = 0;
    std::uint32_t code_ = 0;
    std::uint32_t range_ = 0xffffffffu;
    bool failed_ = false;
    StateDigest digest_;
};

/// Ideal code length of `bit`, bits.
inline double code_length(int bit, Probability set) {
    return -std::log2((bit ? double(set) : 65536.0 - double(set)) / 65536.0);
}

/// Adds up ideal code lengths instead of writing: what something would cost.
class CostCoder {
public:
    static constexpr bool kDecodes = false;
    void code(int& bit, Probability set) { bits_ += code_length(bit, set); }
    bool failed() const { return false; }
    void fail() {}
    double bits() const { return bits_; }

private:
    double bits_ = 0;
};

/// Writes nothing: for walks that only let models learn.
class SilentCoder {
public:
    static constexpr bool kDecodes = false;
    void code(int&, Probability) {}
    bool failed() const { return false; }
    void fail() {}
};

/// `count` bits of equal probability, highest first.
template <class Coder>
void code_plain(Coder& coder, std::uint32_t& value, int count) {
    std::uint32_t out = 0;
    for (int i = count; i-- > 0;) {
        int bit = int(value >> i & 1);
        coder.code(bit, kHalf);
        out = out << 1 | std::uint32_t(bit);
    }
    value = out;
}

}  // namespace mien::coding
