#pragma once

#include <array>

#include "samples/head_muscles.hpp"

namespace mien::samples {

/// Moves a head by ARKit weights: linear muscles with a soft limit, the hinge of the jaw, lids that roll over
/// the eyeballs, lips that cannot pass through each other, eyeballs that turn.
class HeadRig {
public:
    /// `head` must outlive the rig.
    HeadRig(const HeadSurface& surface, const HeadMesh& head);

    Points deform(const Instant& instant) const;
    const std::vector<std::uint32_t>& rigid_vertices() const { return rigid_; }

private:
    using Weights = std::array<float, kArkitCount>;

    void find_jaw(const HeadSurface& surface, const std::vector<MouthPlace>& places);
    void find_lids();
    void find_rigid();
    /// Evens a field over the mesh; vertices marked in `kept` stay.
    void smooth(Eigen::VectorXf& field, const std::vector<char>& kept) const;

    void move_muscles(const Weights& weights, Points& points) const;
    void move_jaw(const Weights& weights, Points& points) const;
    void part_lips(Points& points) const;
    /// Lips that press or roll in come to rest on the crowns.
    void stop_at_teeth(const Weights& weights, Points& points) const;
    void roll_lids(const Weights& weights, const Gaze& gaze, Points& points) const;
    void turn_eyeballs(const Gaze& gaze, Points& points) const;

    /// A vertex of the skin around an eye: it turns about the eye's left-right axis.
    struct LidVertex {
        std::uint32_t vertex;
        int column;  ///< 0 .. half a loop, from the outer corner
        bool upper;
        float share;  ///< of the margin's rotation
    };
    /// One place along the palpebral fissure: angles about the eye's axis, rad, > 0 up.
    struct LidColumn {
        float upper, lower;                ///< of the margins at rest
        float upper_radius, lower_radius;  ///< of the margins from that axis at rest, mm
        float shape;                       ///< 0 at the corners, 1 in the middle
    };

    const HeadMesh& head_;
    std::vector<Muscle> muscles_;
    Eigen::VectorXf jaw_;         ///< V, 0 .. 1: share of the jaw's motion
    Eigen::VectorXf jaw_closed_;  ///< the same while MouthClose holds the lips together
    std::vector<LidVertex> lids_[2];
    std::vector<LidColumn> lid_columns_[2];
    std::vector<std::uint32_t> rigid_;
};

}  // namespace mien::samples
