#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coding/motion_channels.hpp"
#include "coding/quantiser_trellis.hpp"
#include "coding/static_code.hpp"

namespace mien::coding {

/// Codes the frames of a group: one walk that encoder and decoder share. A group starts from begin_group(); then come its
/// objects, each of some frames.
class MotionFrames {
public:
    static constexpr std::uint32_t kMaxFrames = 1u << 20;          ///< of an object: half a day at 24 Hz
    static constexpr std::uint64_t kMaxSamples = 1u << 26;         ///< channels x frames of an object
    static constexpr int kSplits = 3;                              ///< a channel's blocks are halved 0, 1 or 2 times
    static constexpr int kGuenterPredicted = 45;                   ///< components that the 1998 scheme predicts
    static constexpr std::int64_t kMaxSample = std::int64_t(1) << 36;  ///< sixteenths of a step

    MotionFrames(const MotionBasis& basis, const MotionShape& shape);

    void begin_group();

    /// Of the same frames in the rung below, channel by channel as this rung shares them: the coded numbers, and how blocks were
    /// split. Set before each object of a rung that refines another.
    struct Below {
        std::vector<const std::int32_t*> numbers;
        std::vector<std::uint8_t> splits;
    };
    void set_below(Below below) { below_ = std::move(below); }

    /// Presence of every point in each of `frames` frames: frames x points, 0 or 1.
    template <class Coder>
    void code_presence(Coder& coder, std::uint32_t frames, std::vector<std::uint8_t>& presence) {
        presence.resize(std::size_t(frames) * shape_.points);
        for (std::uint32_t f = 0; f < frames && !coder.failed(); ++f) {
            std::uint8_t* here = presence.data() + std::size_t(f) * shape_.points;
            int changed = Coder::kDecodes ? 0 : !std::equal(here, here + shape_.points, present_.begin());
            presence_changes_.code(coder, changed);
            int beside = 0;
            for (std::uint32_t p = 0; p < shape_.points; ++p) {
                int flip = Coder::kDecodes ? 0 : here[p] != present_[p];
                if (changed) presence_flips_[std::size_t(present_[p] * 2 + beside)].code(coder, flip);
                beside = flip;
                present_[p] = std::uint8_t(present_[p] ^ (changed ? flip : 0));
                here[p] = present_[p];
            }
        }
    }

    /// Where one block of one channel lies in the object.
    struct Block {
        int channel = 0;
        std::uint32_t first = 0, length = 0;
        std::int64_t base = 0;  ///< the sample before it, sixteenths: the block's samples are coded as differences from it
    };
    /// One decision of the walk: number `index` (frequency) of a block.
    using Contexts = IntegerModel::Contexts;

    /// transform: one channel of an object. begin_block(block) comes before each block, then decide(index, contexts, model)
    /// -> coefficient for each of its frequencies. numbers: `frames` coefficients; samples: `frames` sixteenths.
    template <class Coder, class BeginBlock, class Decide>
    void code_channel(Coder& coder, int channel, std::uint32_t frames, int& split, BeginBlock&& begin_block,
                      Decide&& decide) {
        const std::int32_t* below = nullptr;
        if (layout_.refines(channel)) {
            below = below_.numbers[std::size_t(channel - layout_.side())];
            split = below_.splits[std::size_t(channel - layout_.side())];
        } else {
            code_split(coder, split);
        }
        splits_[std::size_t(channel)] = std::uint8_t(split);
        const std::uint32_t blocks = std::min(frames, (frames + basis_.block - 1) / basis_.block << split);
        std::int32_t* numbers = row(numbers_, channel, frames);
        const std::int32_t* beside = channel > layout_.side() ? row(numbers_, channel - 1, frames) : zeros_.data();
        const std::int32_t* beyond = channel > layout_.side() + 1 ? row(numbers_, channel - 2, frames) : zeros_.data();
        std::int64_t* samples = samples_.data() + std::size_t(channel) * frames;
        Block block{.channel = channel};
        std::uint32_t length_before = 0;
        for (std::uint32_t b = 0; b < blocks && !coder.failed(); ++b) {
            block.first = std::uint32_t(std::uint64_t(frames) * b / blocks);
            block.length = std::uint32_t(std::uint64_t(frames) * (b + 1) / blocks) - block.first;
            block.base = b ? samples[block.first - 1] : 0;
            begin_block(block);
            const auto magnitude = [](std::int32_t v) { return std::uint32_t(std::min(std::abs(v), 1 << 24)); };
            for (std::uint32_t f = 0; f < block.length; ++f) {
                MotionChannels::Around a;
                const std::uint32_t at = block.first + f;
                if (f > 0) a.last = magnitude(numbers[at - 1]), a.sign = numbers[at - 1];
                if (f > 1) a.before_last = magnitude(numbers[at - 2]);
                a.beside = magnitude(beside[at]);
                if (f > 0) a.beside_last = magnitude(beside[at - 1]);
                if (f + 1 < block.length) a.beside_next = magnitude(beside[at + 1]);
                a.beyond = magnitude(beyond[at]);
                if (below) a.below = magnitude(below[at]);
                if (b > 0 && f < length_before) a.earlier = magnitude(numbers[block.first - length_before + f]);
                const Contexts contexts = layout_.contexts(channel, int(f), a);
                numbers[at] = decide(int(f), contexts, model_);
                model_.code(coder, numbers[at], contexts);
            }
            CosineTransform::of(int(block.length)).inverse(numbers + block.first, samples + block.first);
            for (std::uint32_t t = 0; t < block.length; ++t) {
                samples[block.first + t] += block.base;
                if (std::abs(samples[block.first + t]) > kMaxSample) return coder.fail();
            }
            length_before = block.length;
        }
    }

    /// causal: what channel `channel` has coded around it: the numbers of the two channels before it in this frame, and the size of that
    /// of the nearer one in the last frame.
    struct Beside {
        std::int32_t near = 0, far = 0;
        std::uint32_t last = 0;
    };
    Contexts frame_contexts(int channel, std::uint32_t frame, const Beside& beside, bool shifted) const {
        const auto magnitude = [](std::int32_t v) { return std::uint32_t(std::min(std::abs(v), 1 << 24)); };
        const Past& past = past_[std::size_t(channel)];
        MotionChannels::Around a;
        a.last = past.residual[0];
        a.before_last = past.residual[1];
        a.sign = past.sign;
        if (channel > layout_.side()) a.beside = magnitude(beside.near), a.beside_last = beside.last;
        if (channel > layout_.side() + 1) a.beyond = magnitude(beside.far);
        if (layout_.refines(channel)) a.below = magnitude(below_.numbers[std::size_t(channel - layout_.side())][frame]);
        Contexts contexts = layout_.contexts(channel, int(std::min<std::uint32_t>(age_, 3)), a);
        contexts.shifted = shifted;
        return contexts;
    }
    /// causal: the sample of the next frame as the past has it, sixteenths.
    std::int64_t predict(int channel) const;

    /// causal: one frame of an object, all channels. decide(channel) -> number: an index of QuantiserTrellis, which runs over the channels.
    template <class Coder, class Decide>
    void code_frame(Coder& coder, Decide&& decide, std::uint32_t frame = 0, std::uint32_t frames = 1) {
        int state = 0;
        Beside beside;
        for (int c = 0; c < layout_.total() && !coder.failed(); ++c) {
            Past& past = past_[std::size_t(c)];
            const Contexts contexts = frame_contexts(c, frame, beside, QuantiserTrellis::shifted(state));
            std::int32_t residual = decide(c);
            model_.code(coder, residual, contexts);
            numbers_[std::size_t(c) * frames + frame] = residual;
            const std::int64_t sample = predict(c) + QuantiserTrellis::halves(state, residual) * (MotionBasis::kFraction / 2);
            if (std::abs(sample) > kMaxSample) return coder.fail();
            state = QuantiserTrellis::next(state, residual);
            beside = {residual, beside.near, past.residual[0]};
            past.residual[1] = past.residual[0];
            past.residual[0] = std::uint32_t(std::min(std::abs(residual), 1 << 24));
            past.sign = residual;
            for (std::size_t i = past.sample.size() - 1; i > 0; --i) past.sample[i] = age_ ? past.sample[i - 1] : sample;
            past.sample[0] = sample;
        }
        ++age_;
    }

    /// guenter98: one frame. value(channel, prediction) -> difference in steps.
    template <class Coder, class Decide>
    void code_guenter_frame(Coder& coder, Decide&& decide) {
        for (int c = 0; c < layout_.total() && !coder.failed(); ++c) {
            Past& past = past_[std::size_t(c)];
            const bool predicted = age_ > 0 && c < layout_.side() + kGuenterPredicted;
            const std::int64_t prediction = predicted ? past.sample[0] : 0;
            std::int32_t difference = decide(c, prediction);
            code_static(coder, difference, basis_.static_codes[std::size_t(c)]);
            past.sample[0] = prediction + std::int64_t(difference) * MotionBasis::kFraction;
            if (std::abs(past.sample[0]) > kMaxSample) return coder.fail();
        }
        ++age_;
    }

    /// Decodes all channels of an object of any scheme into samples(): sixteenths of a step, channel by channel.
    template <class Coder>
    void decode(Coder& coder, std::uint32_t frames) {
        static_assert(Coder::kDecodes);
        begin_object(frames);
        if (basis_.scheme == MotionScheme::transform) {
            for (int c = 0; c < layout_.total() && !coder.failed(); ++c) {
                int split = 0;
                coder.enter(c < layout_.side());
                code_channel(coder, c, frames, split, [](const Block&) {}, [](int, const Contexts&, auto&) { return 0; });
            }
            return;
        }
        for (std::uint32_t f = 0; f < frames && !coder.failed(); ++f) {
            if (basis_.scheme == MotionScheme::causal)
                code_frame(coder, [&](int c) { return coder.enter(c < layout_.side()), 0; }, f, frames);
            else
                code_guenter_frame(coder, [&](int c, std::int64_t) { return coder.enter(c < layout_.side()), 0; });
            store_frame(f, frames);
        }
    }

    /// Makes room for an object's samples.
    void begin_object(std::uint32_t frames);
    /// Copies the frame that was just coded into samples().
    void store_frame(std::uint32_t frame, std::uint32_t frames);
    std::int64_t sample(int channel, std::uint32_t frame, std::uint32_t frames) const {
        return samples_[std::size_t(channel) * frames + frame];
    }

    int split(int channel) const { return splits_[std::size_t(channel)]; }
    const MotionChannels& layout() const { return layout_; }
    IntegerModel& model() { return model_; }
    const IntegerModel& model() const { return model_; }
    /// causal: how large the last number of a channel was.
    std::uint32_t last_size(int channel) const { return past_[std::size_t(channel)].residual[0]; }
    /// The coefficients of a channel of the current object, block after block.
    std::span<const std::int32_t> numbers(int channel, std::uint32_t frames) const {
        return {numbers_.data() + std::size_t(channel) * frames, frames};
    }

    /// What code_channel() learns, so that an encoder can try one way and take it back.
    struct Learnt {
        IntegerModel model;
        std::array<AdaptiveBit, 4> split;
        int last_split;
    };
    Learnt learnt() const { return {model_, split_, last_split_}; }
    void restore(const Learnt& learnt) {
        model_ = learnt.model;
        split_ = learnt.split;
        last_split_ = learnt.last_split;
    }

    /// A channel's past inside the group.
    struct Past {
        std::array<std::int64_t, MotionBasis::kMaxOrder> sample{};
        std::array<std::uint32_t, 2> residual{};
        std::int32_t sign = 0;
    };
    /// What the next code_frame() changes take_back_frame() undoes.
    void try_frame() {
        model_.begin_trial();
        past_before_ = past_;
        age_before_ = age_;
    }
    void take_back_frame() {
        model_.take_back();
        past_ = past_before_;
        age_ = age_before_;
    }

private:
    template <class Coder>
    void code_split(Coder& coder, int& split) {
        int more = split > 0;
        split_[std::size_t(last_split_)].code(coder, more);
        if (more) {
            int twice = split > 1;
            split_[3].code(coder, twice);
            split = 1 + twice;
        } else {
            split = 0;
        }
        last_split_ = split;
    }
    static std::int32_t* row(std::vector<std::int32_t>& grid, int channel, std::uint32_t frames) {
        return grid.data() + std::size_t(channel) * frames;
    }

    const MotionBasis& basis_;
    MotionShape shape_;
    MotionChannels layout_;
    IntegerModel start_;
    IntegerModel model_;
    std::array<AdaptiveBit, 4> split_;
    int last_split_ = 0;
    AdaptiveBit presence_changes_;
    std::array<AdaptiveBit, 4> presence_flips_;
    std::vector<std::uint8_t> present_;
    std::vector<std::int32_t> numbers_, zeros_;
    std::vector<std::uint8_t> splits_;   ///< of the current object
    Below below_;
    std::vector<std::int64_t> samples_;
    std::vector<Past> past_, past_before_;
    std::uint32_t age_ = 0, age_before_ = 0;
};

/// A range decoder that also knows what its bits were spent on.
class MeteredDecoder {
public:
    static constexpr bool kDecodes = true;
    explicit MeteredDecoder(ByteView bytes) : decoder_(bytes) {}
    void code(int& bit, Probability set) { decoder_.code(bit, set); }
    /// What follows is of the side channels, or is not.
    void enter(bool side) {
        if (side == side_) return;
        settle();
        side_ = side;
    }
    void fail() { decoder_.fail(); }
    bool failed() const { return decoder_.failed(); }
    bool complete() const { return decoder_.complete(); }
    std::uint64_t digest() const { return decoder_.digest(); }
    double bits(bool side) {
        settle();
        return bits_[side];
    }

private:
    void settle() {
        const double cost = decoder_.cost();
        bits_[side_] += cost - settled_;
        settled_ = cost;
    }

    RangeDecoder decoder_;
    bool side_ = false;
    double settled_ = 0;
    double bits_[2] = {0, 0};
};

}  // namespace mien::coding
