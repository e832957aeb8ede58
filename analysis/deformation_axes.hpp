#pragma once

#include <array>
#include <vector>

#include "model/domain_map.hpp"

namespace mien::analysis {

using Moment = Eigen::Matrix<double, model::kDeformationSize, model::kDeformationSize>;

/// Second moments of deformation vectors about neutral, gathered frame by frame: E[S_i S_i'] of every marker and
/// E[S_i S_j'] of every edge of the marker mesh.
class DeformationMoments {
public:
    explicit DeformationMoments(const model::MarkerMesh& mesh);
    void add(const model::Deformations& S);

    std::int64_t frames() const { return frames_; }
    Moment at(std::size_t marker) const;
    /// Neighbours of a marker, ascending, and E[S_marker S_neighbour'] of the k-th.
    const std::vector<std::uint32_t>& beside(std::size_t marker) const { return beside_[marker]; }
    Moment across(std::size_t marker, std::size_t k) const;
    std::size_t markers() const { return own_.size(); }

private:
    std::vector<std::vector<std::uint32_t>> beside_;
    std::vector<Moment> own_;
    std::vector<std::vector<Moment>> across_;
    std::int64_t frames_ = 0;
};

/// Share of energy that the first 1 .. 5 axes hold at a marker, averaged over the markers that move (Ma et al. 2008, Table 1).
std::array<double, model::kDeformationSize> axis_energy(const DeformationMoments& moments);

enum class AxisSmoothing {
    frames,  ///< planes stay; inside each, axes are turned (Procrustes) so that d1 and d2 run like the neighbours'
    paper,   ///< the worst outlier becomes the mean of its neighbours, again and again (Ma et al. 2008, section 4.1)
    none,
};

/// Which plane of S a marker's d1 and d2 lie in.
enum class AxisChoice {
    principal,  ///< the one that S itself moves in most (Ma et al. 2008, section 4.1)
    telling,    ///< the one that the layers around the marker follow best, what they do being taken as linear in S
};

struct AxisOptions {
    AxisChoice choice = AxisChoice::telling;
    AxisSmoothing smoothing = AxisSmoothing::frames;
    double outlier_degrees = 20;  ///< paper: the angle below which no axis is an outlier
    int most_steps = 20'000;      ///< paper: it need not end by itself
};

/// Axes Q, R of every marker: two of S about neutral, smoothed over the mesh, scaled so that d1 and d2 have unit RMS over the
/// gathered frames. `frames` whitens: d1 and d2 are also uncorrelated, and any turn inside the plane keeps them so. Markers that
/// hardly move (RMS far below the others') are scaled less, so that noise is not blown up.
/// `slopes`: for AxisChoice::telling, per marker the sum of b b' over everything around it that changes by b'S; the mean of its neighbours' counts as much.
/// The plane is that of the reduced-rank regression of rank two (Izenman 1975): what is left of the changes outside it has the least
/// energy, and some of the energy of S itself counts as a change. Empty, and where nothing changes: the principal axes.
model::DomainAxes deformation_axes(const DeformationMoments& moments, const AxisOptions& options = {}, const std::vector<Moment>& slopes = {});

}  // namespace mien::analysis
