#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coding/point_order.hpp"

namespace mien::coding {

/// What a surprise at one point does to all points coded after it: prediction is linear, so a vector is the sum of its
/// surprises (value less weighted mean of the references) times these columns. For encoders; real numbers, tails cut off.
class PointInfluence {
public:
    struct Share {
        std::uint32_t point;
        float weight;
    };
    explicit PointInfluence(const PointOrder& order);

    /// By position in the order: the points it moves, itself (weight 1) first.
    std::span<const Share> of(std::size_t position) const {
        return {shares_.data() + first_[position], shares_.data() + first_[position + 1]};
    }
    /// Sum of squared weights.
    float energy(std::size_t position) const { return energy_[position]; }

private:
    std::vector<std::size_t> first_;
    std::vector<Share> shares_;
    std::vector<float> energy_;
};

}  // namespace mien::coding
