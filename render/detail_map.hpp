#pragma once

#include <vector>

#include "core/image.hpp"
#include "model/detail_layers.hpp"
#include "render/gl.hpp"

namespace mien::render {

/// The fine and albedo maps of a detail model, evaluated on the GPU into one picture in texture space: linear albedo in red, green and
/// blue, height along the normal in mm in alpha. The picture has the map's own size, or half of it each way, and so on, by how large
/// the face is drawn.
class DetailMap {
public:
    /// `still`: colour of what the albedo map does not cover, the size does not matter; null: the map's own resting colours, spread out.
    DetailMap(const model::DetailLayers& layers, const Image* still);

    bool has_albedo() const { return has_albedo_; }
    bool has_fine() const { return has_fine_; }

    /// Evaluates all texels for d1, d2 as DetailShape forms them. texels_per_pixel: of the full map, where the face is drawn.
    void evaluate(const gl::Buffer& parameters, float texels_per_pixel);
    /// Binds the picture of the last evaluation.
    void bind(GLuint unit) const;

    FloatMap read() const;   ///< 4 channels, for tests

private:
    struct Level {
        int width = 0, height = 0;
        gl::Texture domain, coefficients, still, value;
        gl::Framebuffer target;
        gl::Buffer squares;
        gl::VertexArray layout;
        GLsizei corner_count = 0;
    };
    struct Texels;
    void make_level(const Texels& texels, const FloatMap& still, int terms);

    bool has_albedo_ = false, has_fine_ = false;
    gl::Program program_;
    gl::Texture parameters_;      // the buffer that `evaluate` is given, as a texture
    GLuint parameters_buffer_ = 0;
    std::vector<Level> levels_;
    std::size_t shown_ = 0;
};

}  // namespace mien::render
