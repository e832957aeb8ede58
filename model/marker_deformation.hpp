#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/mesh.hpp"

namespace mien::model {

/// {O (3), E^u, E^v}: offset and in-plane strain at a marker, mm (Ma et al. 2008, section 4.1).
inline constexpr int kDeformationSize = 5;
using Deformations = Eigen::Matrix<float, Eigen::Dynamic, kDeformationSize, Eigen::RowMajor>;  ///< one row per marker

/// The coarse mesh over the markers that deformation is measured on.
struct MarkerMesh {
    Points neutral;                       ///< M x 3, mm, head space
    std::vector<Triangle> triangles;      ///< over the markers; where the texture has a cut, they have one too
    Points u, v;                          ///< M x 3, unit tangents of the neutral surface along the texture axes
};

/// Unit tangents of the neutral surface along the texture's u and v at the sites, M x 3 each; (x, y) where the texture
/// says nothing. The mesh has texture coordinates.
MarkerMesh make_marker_mesh(const Mesh& neutral, const std::vector<Site>& sites, std::vector<Triangle> triangles);

/// Measures deformation vectors S_i on a marker mesh.
class DeformationMeter {
public:
    explicit DeformationMeter(MarkerMesh mesh);

    const MarkerMesh& mesh() const { return mesh_; }
    Eigen::Index markers() const { return mesh_.neutral.rows(); }
    /// Markers within two edges of marker i, i included: N2(i), ascending.
    const std::vector<std::uint32_t>& neighbourhood(std::size_t i) const { return near_[i]; }

    /// Standard deviations over N2(i) at neutral, mm: (along u, along v).
    const Eigen::Vector2f& neutral_spread(std::size_t i) const { return neutral_spread_[i]; }

    /// S of every marker. `markers`: M x 3 in head space (head pose removed), all there. O_i is the offset from neutral;
    /// E_i = sqrt|N2(i)| (sd{t . P_j} - sd{t . P_j neutral}) over N2(i) for t = u, v (equation 2).
    Deformations measure(PointsRef markers) const;

private:
    Eigen::Vector2f spread(PointsRef markers, std::size_t i) const;  // standard deviations along u and v

    MarkerMesh mesh_;
    std::vector<std::vector<std::uint32_t>> near_;
    std::vector<Eigen::Vector2f> neutral_spread_;
};

/// Puts back markers that are missing (NaN): their offsets from neutral become the mean of their neighbours' on the marker
/// mesh (a membrane); markers without any neighbour get the mean of all. False when every marker is missing.
bool fill_missing_markers(const MarkerMesh& mesh, Eigen::Ref<Points> markers);

}  // namespace mien::model
