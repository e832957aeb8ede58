#pragma once

#include <vector>

#include "core/image.hpp"
#include "render/gl.hpp"

namespace mien::render {

/// The colour of the skin as textures: video planes still Y'CbCr, or one RGB picture. Rows from the top.
class Albedo {
public:
    enum class Kind { none, rgb, yuv, map };

    void set(const YuvView& picture);
    void set(const Image& picture);
    void clear() { kind_ = Kind::none; }

    Kind kind() const { return kind_; }
    /// Binds textures 0 and 1 and sets the uniforms of albedo sampling.
    void apply(gl::Program& program) const;
    static const char* defines(Kind kind);

private:
    struct Plane {
        gl::Texture texture;
        int width = 0, height = 0;
        GLenum format = 0;
    };
    void allocate(Plane& plane, int width, int height, GLenum format);

    Kind kind_ = Kind::none;
    Plane luma_, chroma_;             ///< chroma_: Cb and Cr side by side
    std::vector<std::uint8_t> pairs_; ///< of chroma_, on the way there
    Plane picture_;
    Eigen::Matrix3f to_rgb_ = Eigen::Matrix3f::Identity();
    Vec3 offset_ = Vec3::Zero();
    Eigen::Vector4f chroma_place_{1, 1, 0, 0};   ///< scale and offset from luma to chroma texture coordinates
};

}  // namespace mien::render
