#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coding/integer_model.hpp"
#include "coding/motion_basis.hpp"

namespace mien::coding {

/// What components leave of single points: corrections of a few points (or weights), each held until it changes. Both sides
/// run this one walk, after the channels of an object, frame by frame.
class MotionCorrections {
public:
    /// A corrected point takes another value.
    struct Change {
        std::uint32_t at = 0;               ///< number in MotionBasis::corrected
        std::array<std::int32_t, 3> value{};  ///< from now on, in correction steps; the first `coordinates` count
    };
    static constexpr std::int32_t kMaxValue = 1 << 24;

    MotionCorrections(const MotionBasis& basis, const MotionShape& shape);

    /// Nothing is corrected any more.
    void begin_group();

    /// One frame. changes: those of the frame, ascending and each a real one; a decoder fills them in.
    template <class Coder>
    void code(Coder& coder, std::vector<Change>& changes) {
        if (Coder::kDecodes) changes.clear();
        int any = Coder::kDecodes ? 0 : !changes.empty();
        any_[std::size_t(any_last_)].code(coder, any);
        any_last_ = any;
        if (any) code_changes(coder, changes);
        else std::fill(changed_.begin(), changed_.end(), std::uint8_t(0));
    }

    /// What holds now: points x coordinates, in steps.
    std::span<const std::int32_t> values() const { return values_; }

private:
    static constexpr int kNames = 256, kLimit = 250;
    static constexpr std::array<int, 4> kFlagContexts{kNames, 2 * 8, 16 * 2, 5 * 5};
    static constexpr std::array<int, 3> kValueContexts{3 * 5 * 5, 3 * 5, 3 * 4 * 4};

    template <class Coder>
    void code_changes(Coder& coder, std::vector<Change>& changes) {
        const std::size_t count = changed_.size();
        std::array<std::int32_t, 3> beside{};   // what the last changed point did
        std::uint32_t changed = 0;
        std::size_t next = 0;
        last_ = changed_;
        for (std::size_t i = 0; i < count && !coder.failed(); ++i) {
            std::int32_t* value = values_.data() + i * coordinates_;
            int flag = Coder::kDecodes ? 0 : next < changes.size() && changes[next].at == i;
            flags_.code_flag(coder, flag, flag_contexts(i, changed));
            changed_[i] = std::uint8_t(flag);
            if (age_[i] < 255) ++age_[i];
            if (!flag) continue;
            std::array<std::int32_t, 3> moves{};
            for (std::size_t c = 0; c < coordinates_; ++c) {
                moves[c] = Coder::kDecodes ? 0 : changes[next].value[c] - value[c];
                move_.code(coder, moves[c], move_contexts(c, value[c], beside, moves));
                if (std::abs(std::int64_t(value[c]) + moves[c]) > kMaxValue) return coder.fail();
                value[c] += moves[c];
            }
            if (Coder::kDecodes) {
                changes.push_back({std::uint32_t(i), {}});
                std::copy_n(value, coordinates_, changes.back().value.begin());
            }
            beside = moves;
            age_[i] = 0;
            ++changed;
            ++next;
        }
        count_last_ = changed;
    }

    IntegerModel::Contexts flag_contexts(std::size_t i, std::uint32_t changed) const {
        const std::size_t count = changed_.size();
        const std::int32_t* value = values_.data() + i * coordinates_;
        const bool held = std::any_of(value, value + coordinates_, [](std::int32_t v) { return v != 0; });
        IntegerModel::Contexts c;
        c.input[0] = int(count <= kNames ? i : i * kNames / count);
        c.input[1] = int(held) * 8 + magnitude_level(age_[i], 8);
        const int one = i > 0 ? changed_[i - 1] : 0, two = i > 1 ? changed_[i - 2] : 0;
        c.input[2] = (one * 8 + two * 4 + last_[i] * 2 + (i + 1 < count ? last_[i + 1] : 0)) * 2 + int(held);
        c.input[3] = magnitude_level(changed, 5) * 5 + magnitude_level(count_last_, 5);
        return c;
    }

    IntegerModel::Contexts move_contexts(std::size_t c, std::int32_t held, const std::array<std::int32_t, 3>& beside,
                                         const std::array<std::int32_t, 3>& moves) const {
        const auto size = [](std::int32_t v, int levels) { return magnitude_level(std::uint32_t(std::abs(v)), levels); };
        const auto sign = [](std::int32_t v) { return v > 0 ? 2 : v < 0 ? 0 : 1; };
        IntegerModel::Contexts contexts;
        contexts.input[0] = (int(c) * 5 + size(held, 5)) * 5 + size(beside[c], 5);
        contexts.input[1] = int(c) * 5 + size(beside[c], 5);
        contexts.input[2] = (int(c) * 4 + (c > 0 ? size(moves[c - 1], 4) : 0)) * 4 + (c > 1 ? size(moves[c - 2], 4) : 0);
        contexts.sign = sign(held) * 3 + sign(beside[c]);
        return contexts;
    }

    std::size_t coordinates_;
    IntegerModel flags_, move_;
    std::array<AdaptiveBit, 2> any_;
    int any_last_ = 0;
    std::uint32_t count_last_ = 0;
    std::vector<std::int32_t> values_;
    std::vector<std::uint8_t> changed_, last_;   ///< in this frame, in the frame before
    std::vector<std::uint8_t> age_;              ///< frames with changes since the point's own
};

}  // namespace mien::coding
