#include "render/shadow_map.hpp"

#include "embedded_mien_render.hpp"

namespace mien::render {

ShadowMap::ShadowMap() : framebuffer_(gl::make_framebuffer()), program_(gl::make_program(embedded::shaders_shadow_vert, embedded::shaders_shadow_frag)) {
    glNamedFramebufferDrawBuffer(framebuffer_.id(), GL_NONE);
}

void ShadowMap::allocate(int side) {
    side_ = side;
    depth_ = gl::make_texture(GL_TEXTURE_2D);
    const GLuint id = depth_.id();
    glTextureStorage2D(id, 1, GL_DEPTH_COMPONENT16, side, side);   // steps of some hundredths of a millimetre
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTextureParameteri(id, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glNamedFramebufferTexture(framebuffer_.id(), GL_DEPTH_ATTACHMENT, id, 0);
}

Eigen::Matrix4f ShadowMap::projection(const Vec3& towards_light, const Vec3& centre, float radius) {
    const Vec3 right = Vec3::UnitY().cross(towards_light).normalized();
    const Vec3 above = towards_light.cross(right);
    Eigen::Matrix4f m = Eigen::Matrix4f::Identity();
    m.block<1, 3>(0, 0) = right.transpose() / radius;
    m.block<1, 3>(1, 0) = above.transpose() / radius;
    m.block<1, 3>(2, 0) = -towards_light.transpose() / radius;
    m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * centre;
    return m;
}

void ShadowMap::draw(const gl::VertexArray& casters, GLsizei index_count, GLsizei solid, const Eigen::Matrix4f& projection, int lines) {
    // Fine enough for the shadow of a nose; face.frag softens it over some texels.
    if (const int side = lines < 640 ? 512 : 1024; side != side_) allocate(side);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, side_, side_);
    glClear(GL_DEPTH_BUFFER_BIT);
    glBindVertexArray(casters.id());
    program_.set("light_projection", projection);
    program_.use();
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(2.0f, 2.0f);
    glEnable(GL_CULL_FACE);
    glDrawElements(GL_TRIANGLES, solid, GL_UNSIGNED_INT, nullptr);
    glDisable(GL_CULL_FACE);
    glDrawElements(GL_TRIANGLES, index_count - solid, GL_UNSIGNED_INT, reinterpret_cast<const void*>(sizeof(std::uint32_t) * std::size_t(solid)));
    glDisable(GL_POLYGON_OFFSET_FILL);
    glBindTextureUnit(3, depth_.id());
}

}  // namespace mien::render
