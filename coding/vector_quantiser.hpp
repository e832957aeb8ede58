#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "coding/motion_basis.hpp"

namespace mien::coding {

/// Quantises vectors over points one after another, as VectorCoder will code them, weighing bits against squared error.
///
/// A coarse point's value moves every point that is predicted from it (PointInfluence), so its error counts for all of
/// them, and what it should be depends on what they cannot mend: rounds of relaxed coordinate descent over the surprises.
class VectorQuantiser {
public:
    VectorQuantiser(const MotionShape& shape, const PointOrder& order, const std::array<std::uint8_t, PointOrder::kLevels>& level_steps);
    ~VectorQuantiser();

    /// values: d, in the units that level steps count. lambda: squared units per bit; 0: to the nearest. rounds >= 1; in
    /// the first every value is taken for itself. Returns the vector as a decoder has it and adds its cost.
    std::vector<std::int32_t> quantise(std::span<const double> values, double lambda, int rounds);
    double bits() const;

    /// Learns from vectors of lower rungs, as VectorCoder does.
    void learn(std::span<const std::vector<std::int32_t>> vectors);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::coding
