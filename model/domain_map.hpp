#pragma once

#include <cstdint>
#include <vector>

#include "core/texel_map.hpp"
#include "model/marker_deformation.hpp"

namespace mien::model {

/// The texels a polynomial map covers and where each lies on the marker mesh: marker triangle and barycentric weights in
/// texture space. Texels are ordered by triangle, then by rows, so that each triangle's are one run.
struct DomainMap {
    struct Run {
        std::uint32_t triangle;       ///< of MarkerMesh::triangles
        std::uint32_t begin, end;     ///< texels begin <= i < end
    };
    int width = 0, height = 0;
    std::vector<Run> runs;
    std::vector<std::uint32_t> place;  ///< texel i is at y * width + x
    std::vector<float> b1, b2;         ///< weights of the triangle's second and third corner

    std::size_t size() const { return place.size(); }
};

/// The domain of `texels` (those of skin) on a marker mesh. Texels inside a marker triangle lie there; others take the
/// nearest place of the triangles around the marker that is nearest along the skin, so that no texel of the upper lip
/// follows the lower one, up to `reach` mm from it. `wanted`, if not empty, leaves out texels where it is 0 (width * height).
DomainMap make_domain_map(const Mesh& neutral, const TexelMap& texels, const std::vector<Site>& sites, const MarkerMesh& markers,
                          float reach, const std::vector<std::uint8_t>& wanted = {});

/// Texture coordinates of a site: of the first triangle that has all its vertices.
std::vector<Vec2> site_texcoords(const Mesh& neutral, const std::vector<Site>& sites);

/// Axes Q, R of every marker: d1 = S . Q, d2 = S . R (Ma et al. 2008, equation 3). Scales that make d1 and d2 of unit RMS over
/// the training frames are inside.
struct DomainAxes {
    Deformations q, r;        ///< M x 5 each
    Eigen::VectorXf extents;  ///< M, or none: how long (d1, d2) may be at a marker, what lies beyond being drawn back
};

/// d1 and d2 of one frame over the whole domain. On a marker triangle S, Q and R are linear in (b1, b2), so both are
/// quadratic: c[0] + c[1] b1 + c[2] b2 + c[3] b1² + c[4] b1 b2 + c[5] b2².
struct DomainParameters {
    struct Quadratic {
        float c[6];
        float at(float b1, float b2) const {
            return c[0] + b1 * (c[1] + c[3] * b1 + c[4] * b2) + b2 * (c[2] + c[5] * b2);
        }
    };
    std::vector<Quadratic> d1, d2;  ///< one per marker triangle
};
DomainParameters domain_parameters(const MarkerMesh& mesh, const DomainAxes& axes, const Deformations& S);

/// Longest (d1, d2) of every marker so far; `longest` is empty or M.
void add_extents(Eigen::VectorXf& longest, const DomainAxes& axes, const Deformations& S);

}  // namespace mien::model
