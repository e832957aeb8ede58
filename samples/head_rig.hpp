#pragma once

#include "samples/head_mesh.hpp"

namespace mien::samples {

/// Moves a head by ARKit weights: linear muscles, the hinge of the jaw, lids that roll over the eyeballs, eyeballs.
class HeadRig {
public:
    HeadRig(const HeadSurface& surface, const HeadMesh& head);

    Points deform(const Instant& instant) const;
    const std::vector<std::uint32_t>& rigid_vertices() const { return rigid_; }

private:
    void add_jaw_weights(const HeadSurface& surface);
    void smooth(Eigen::VectorXf& field, const std::vector<char>& kept) const;
    void find_rigid();

    const HeadMesh& head_;
    Eigen::VectorXf jaw_;  ///< V, 0 .. 1: share of the jaw's motion
    std::vector<std::uint32_t> rigid_;
};

}  // namespace mien::samples
