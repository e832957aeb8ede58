#pragma once

#include "core/geometry.hpp"
#include "render/detail_pictures.hpp"
#include "render/gl.hpp"

namespace mien::render {

/// What a detail model adds to a formed base shape on the GPU: deformation at the markers, d1 and d2 over the marker triangles, and
/// the medium layer on the vertices.
class DetailShape {
public:
    explicit DetailShape(const model::DetailLayers& layers);

    /// Puts medium_coefficients() of the same model, with more stages, in the place of those that are used; `budget` and result as DetailMap::take's.
    bool take(const std::vector<float>& medium, std::size_t& budget);

    /// positions: V x 3 floats, posed by `pose`. Measures them, then moves them by the medium layer if it is wanted.
    void form(const gl::Buffer& positions, const RigidPose& pose, bool medium);

    /// 12 floats per marker triangle: six of d1, six of d2 (model::DomainParameters).
    const gl::Texture& parameters() const { return parameter_texels_; }
    model::DomainParameters read_parameters() const;   ///< for tests

private:
    void make_markers(const model::DetailLayers& layers);
    void make_moved(const model::DetailLayers& layers);

    int marker_count_ = 0, triangle_count_ = 0, moved_count_ = 0;
    gl::Program deformation_program_, parameters_program_, medium_program_;
    gl::Buffer markers_, near_, triangles_, deformations_, parameters_, moved_, places_, coefficients_;
    gl::Texture place_texels_, coefficient_texels_, parameter_texels_;   // of medium.comp
    gl::Buffer coming_;             // coefficients that are under way
    std::size_t taken_ = 0;         // numbers of them that are there
};

}  // namespace mien::render
