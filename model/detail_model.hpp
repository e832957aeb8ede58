#pragma once

#include <vector>

#include "core/texel_map.hpp"
#include "model/polynomial_map.hpp"

namespace mien::model {

/// The detail of a face as layers over markers (Ma et al. 2008): base shape by a linear thin shell, medium displacement, fine
/// displacement along the normal and albedo as polynomial maps of d1, d2.
struct DetailModel {
    Mesh neutral;                         ///< with texture coordinates; positions of the base shape at rest
    std::vector<Site> sites;              ///< M, of the markers on `neutral`
    std::vector<std::uint32_t> fixed;     ///< vertices that the base shape never moves
    std::vector<Triangle> marker_triangles;
    DomainAxes axes;
    float reach = 30;                     ///< mm along the skin from the nearest marker to the farthest texel
    DomainMap medium_domain, fine_domain;
    PolynomialMap medium;                 ///< 3 channels: displacement of the base shape in head space, mm
    PolynomialMap fine;                   ///< 1 channel: displacement along the normal of the medium surface, mm
    PolynomialMap albedo;                 ///< 3 channels, linear, over fine_domain; no planes: none was trained
};

/// The skin texels of a width x height map that lie within the model's reach; `wanted` as for make_domain_map. Needs neutral, sites,
/// marker_triangles and reach. The same on every machine that rounds as IEEE 754 says.
DomainMap detail_domain(const DetailModel& model, int width, int height, const std::vector<std::uint8_t>& wanted = {});

/// Everything one frame's markers decide.
struct DrivenFrame {
    Deformations S;
    DomainParameters parameters;
    Points base;       ///< V x 3, the thin shell's vertices, mm, head space
};

/// Drives the base shape and the domain of a face by its markers. Loading solves the thin shell once.
class MarkerDriver {
public:
    MarkerDriver(const Mesh& neutral, const std::vector<Site>& sites, const std::vector<std::uint32_t>& fixed, std::vector<Triangle> marker_triangles);

    const DeformationMeter& meter() const { return meter_; }
    const MarkerMesh& mesh() const { return meter_.mesh(); }
    const Eigen::MatrixXf& response() const { return response_; }  ///< V x M

    /// markers: M x 3, head space; missing ones (NaN) are filled in. With all missing, the face is at rest.
    DrivenFrame drive(PointsRef markers, const DomainAxes& axes) const;
    /// The base shape alone, V x 3 mm; no marker is missing.
    Points base(PointsRef markers) const { return neutral_ + response_ * (markers - mesh().neutral); }

private:
    Points neutral_;
    Eigen::MatrixXf response_;
    DeformationMeter meter_;
};

/// Bilinear place of any texture coordinate among the texels of a domain: up to four texels with weights that sum to 1, those
/// outside the domain left out; none when all four are.
class DomainSampler {
public:
    explicit DomainSampler(const DomainMap& domain);
    struct Sample {
        std::uint32_t texel[4];
        float weight[4];
        int count = 0;
    };
    Sample at(const Vec2& uv) const;

private:
    int width_, height_;
    std::vector<std::uint32_t> number_;  // of the texel at a place, or kNone
};

/// One value of a sampled map of `texels` texels: channel c.
inline float sampled(const DomainSampler::Sample& sample, const float* values, std::size_t texels, int c) {
    float sum = 0;
    for (int k = 0; k < sample.count; ++k) sum += sample.weight[k] * values[std::size_t(c) * texels + sample.texel[k]];
    return sum;
}

/// The base shape with the medium layer on: every vertex moved by what the medium map says at its texture coordinates.
/// `medium`: values of the frame, [3][texels].
class MediumSurface {
public:
    MediumSurface(const Mesh& neutral, const DomainMap& medium_domain);
    Points move(PointsRef base, const float* medium) const;
    /// Where a vertex lies among the map's texels; count 0: it never moves.
    const DomainSampler::Sample& sample(std::size_t vertex) const { return samples_[vertex]; }

private:
    std::vector<DomainSampler::Sample> samples_;  // of every vertex
    std::size_t texels_;
};

}  // namespace mien::model
