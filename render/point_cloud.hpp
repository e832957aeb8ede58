#pragma once

#include "model/face_model.hpp"
#include "render/camera.hpp"
#include "render/gl.hpp"
#include "render/look.hpp"

namespace mien::render {

/// Markers without a mesh: little lit balls, and the edges of their triangulation as lines.
class PointCloud {
public:
    explicit PointCloud(const model::PointBase& base);

    void set_presence(const std::vector<std::uint8_t>& presence);   ///< M, 0 = not drawn; empty: all are
    /// lines_only: no balls.
    void draw(const gl::Buffer& positions, const Camera& camera, float aspect, int height, const Lighting& lighting,
              bool lines_only);

private:
    int count_ = 0;
    float radius_ = 1;                  ///< mm
    GLsizei line_indices_ = 0;
    gl::Buffer presence_, edges_;
    gl::VertexArray points_layout_, lines_layout_;
    gl::Program point_, line_;
};

}  // namespace mien::render
