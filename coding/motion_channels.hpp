#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "coding/cosine_transform.hpp"
#include "coding/integer_model.hpp"
#include "coding/motion_basis.hpp"

namespace mien::coding {

/// The channels of a motion track, in coding order: pose (translation x y z, rotation vector x y z), gaze (yaw and pitch of
/// the right eye, then of the left), then the components; and the contexts their numbers are coded in.
class MotionChannels {
public:
    MotionChannels(const MotionShape& shape, const MotionBasis& basis)
        : side_(shape.side_channels()), total_(basis.channels(shape)), shared_(side_ + int(basis.shared)), gaze_only_(shape.gaze && !shape.pose),
          dependent_(basis.scheme == MotionScheme::causal) {
        if (basis.shared > 0) counts_.back() *= 2;
    }

    int side() const { return side_; }
    int total() const { return total_; }
    bool refines(int channel) const { return channel >= side_ && channel < shared_; }

    /// Decisions per context: numbers of QuantiserTrellis have some more.
    std::size_t bins() const { return std::size_t(Binarisation::kBins + (dependent_ ? Binarisation::kShiftedBins : 0)); }
    /// A model that has learnt nothing, but expects numbers about as large as their neighbours.
    IntegerModel make_model() const;
    std::size_t model_entries() const {
        std::size_t entries = 0;
        for (int count : counts_) entries += std::size_t(count) * bins();
        return entries;
    }
    std::size_t model_weights() const { return bins() * kInputs; }
    static constexpr std::size_t kInputs = 6;

    /// Magnitudes of numbers coded before, and the sign of the last.
    struct Around {
        std::uint32_t last = 0, before_last = 0;                   ///< of this channel, at f - 1 and f - 2
        std::uint32_t beside = 0, beside_next = 0, beside_last = 0;  ///< of the channel before, at f, f + 1, f - 1
        std::uint32_t beyond = 0;                                  ///< of the channel before that, at f
        std::uint32_t earlier = 0;                                 ///< of this channel, at f of the block before
        std::uint32_t below = 0;                                   ///< where a channel refines another: of that, at f
        int sign = 0;
    };
    /// index: frequency in a block, or frames since the group's start. scale: how many of them there are.
    IntegerModel::Contexts contexts(int channel, int index, const Around& a) const {
        const int component = channel - side_;
        const int id = component >= 0 ? 10 + std::min(component, 53) : channel + (gaze_only_ ? 6 : 0);
        const int kind = component < 0 ? 0 : component < 4 ? 1 : component < 16 ? 2 : 3;
        const int band = index < 3 ? index : index < 5 ? 3 : index < 8 ? 4 : index < 12 ? 5 : index < 20 ? 6 : 7;
        IntegerModel::Contexts c;
        c.input[0] = id * 8 + band;
        c.input[1] = (magnitude_level(a.last, 6) * 6 + magnitude_level(a.before_last, 6)) * 8 + band;
        c.input[2] = (magnitude_level(2 * a.beside + a.beside_last + a.beside_next + a.beyond, 8) * 8 + band) * 3 +
                     magnitude_level(a.earlier, 3);
        const std::uint32_t around = index > 0 ? 4 * a.last + 2 * a.before_last + 2 * a.beside + a.beside_last + a.beside_next +
                                                     a.beyond + 2 * a.earlier
                                               : 5 * a.beside + 3 * a.beyond + 4 * a.earlier;
        c.input[3] = fine_level(around) * 4 + kind;
        c.input[4] = id * 4 + magnitude_level(a.last + a.before_last, 4);
        c.input[5] = refines(channel) ? kContexts[5] + (magnitude_level(a.below, 8) * 8 + band) * 4 + kind : std::min(index, 63) * 4 + kind;
        c.sign = a.sign > 0 ? 2 : a.sign < 0 ? 0 : 1;
        return c;
    }

private:
    static constexpr int kLimit = 200;
    static constexpr std::array<int, kInputs> kContexts{64 * 8, 36 * 8, 8 * 8 * 3, 32 * 4, 64 * 4, 64 * 4};

    static int fine_level(std::uint32_t m) {
        if (m < 2) return int(m);
        const int top = 31 - __builtin_clz(m);
        return std::min(31, 2 * top + int(m >> (top - 1) & 1));
    }

    int side_, total_, shared_;
    bool gaze_only_, dependent_;
    std::array<int, kInputs> counts_ = kContexts;
};

}  // namespace mien::coding
