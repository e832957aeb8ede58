#pragma once

#include "render/gl.hpp"

namespace mien::render {

/// How far the key light gets: a depth picture from its side. Leaves its texture bound to unit 3.
class ShadowMap {
public:
    ShadowMap();

    /// Clip-space matrix of a far light over a sphere of the scene (mm).
    static Eigen::Matrix4f projection(const Vec3& towards_light, const Vec3& centre, float radius);

    /// `lines`: of the picture that it is for, which needs no finer one. `solid`: so many indices, the first ones, are of
    /// surfaces that enclose something. Of these only what faces the light casts: the rest lies behind it.
    void draw(const gl::VertexArray& casters, GLsizei index_count, GLsizei solid, const Eigen::Matrix4f& projection, int lines);

private:
    void allocate(int side);

    int side_ = 0;   // texels
    gl::Texture depth_;
    gl::Framebuffer framebuffer_;
    gl::Program program_;
};

}  // namespace mien::render
