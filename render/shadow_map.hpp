#pragma once

#include "render/gl.hpp"

namespace mien::render {

/// How far the key light gets: a depth picture from its side. Leaves its texture bound to unit 3.
class ShadowMap {
public:
    /// side: texels.
    explicit ShadowMap(int side);
    int side() const { return side_; }
    /// Fine enough for the shadow of a nose in a picture of so many lines; face.frag softens it over some texels.
    static int side_for(int lines) { return lines < 640 ? 512 : 1024; }

    /// Clip-space matrix of a far light over a sphere of the scene (mm).
    static Eigen::Matrix4f projection(const Vec3& towards_light, const Vec3& centre, float radius);

    /// `solid`: so many indices, the first ones, are of surfaces that enclose something. Of these only what faces the light
    /// casts: the rest lies behind it.
    void draw(const gl::VertexArray& casters, GLsizei index_count, GLsizei solid, const Eigen::Matrix4f& projection);

private:
    int side_;
    gl::Texture depth_;
    gl::Framebuffer framebuffer_;
    gl::Program program_;
};

}  // namespace mien::render
