#include "render/albedo.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

#include "render/context.hpp"

namespace mien::render {
namespace {

/// Y'CbCr in [0, 1] per sample -> R'G'B': rgb = to_rgb * (yuv - offset). ITU-T H.273, matrix coefficients 1 and 6.
void conversion(YuvView::Matrix matrix, bool full_range, Eigen::Matrix3f& to_rgb, Vec3& offset) {
    const float kr = matrix == YuvView::Matrix::bt709 ? 0.2126f : 0.299f;
    const float kb = matrix == YuvView::Matrix::bt709 ? 0.0722f : 0.114f;
    const float kg = 1 - kr - kb;
    const float luma = full_range ? 1 : 255.0f / 219, chroma = full_range ? 1 : 255.0f / 224;
    const float r = 2 * (1 - kr), b = 2 * (1 - kb);
    to_rgb << luma, 0, chroma * r,                                //
        luma, -chroma * b * kb / kg, -chroma * r * kr / kg,       //
        luma, chroma * b, 0;
    offset = Vec3(full_range ? 0 : 16.0f / 255, 128.0f / 255, 128.0f / 255);
}

}  // namespace

void Albedo::allocate(Plane& plane, int width, int height, GLenum format) {
    if (plane.width == width && plane.height == height && plane.format == format) return;
    plane.texture = gl::make_texture(GL_TEXTURE_2D);
    plane.width = width;
    plane.height = height;
    plane.format = format;
    // Down to 32 texels: nobody sees a face that small, and every level costs a pass.
    const int levels = std::max(1, int(std::bit_width(unsigned(std::max(width, height)))) - 5);
    const GLuint id = plane.texture.id();
    glTextureStorage2D(id, levels, format, width, height);
    // A CPU pays for every sample, and one level is enough where nothing glides away into the distance.
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, is_software_renderer() ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void Albedo::set(const YuvView& picture) {
    assert(picture.width > 0 && picture.height > 0);
    kind_ = Kind::yuv;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    allocate(luma_, picture.width, picture.height, GL_R8);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, picture.strides[0]);
    glTextureSubImage2D(luma_.texture.id(), 0, 0, 0, picture.width, picture.height, GL_RED, GL_UNSIGNED_BYTE, picture.planes[0]);
    glGenerateTextureMipmap(luma_.texture.id());

    // Both colour differences in one texture: one look-up a fragment less.
    const int width = picture.chroma_width, height = picture.chroma_height;
    pairs_.resize(std::size_t(width) * height * 2);
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* blue = picture.planes[1] + std::ptrdiff_t(y) * picture.strides[1];
        const std::uint8_t* red = picture.planes[2] + std::ptrdiff_t(y) * picture.strides[2];
        std::uint8_t* pair = pairs_.data() + std::size_t(y) * width * 2;
        for (int x = 0; x < width; ++x) pair[2 * x] = blue[x], pair[2 * x + 1] = red[x];
    }
    allocate(chroma_, width, height, GL_RG8);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glTextureSubImage2D(chroma_.texture.id(), 0, 0, 0, width, height, GL_RG, GL_UNSIGNED_BYTE, pairs_.data());
    glGenerateTextureMipmap(chroma_.texture.id());
    conversion(picture.matrix, picture.full_range, to_rgb_, offset_);
    // OpenGL takes chroma samples as centred on the luma they cover; half a luma sample puts right those that lie on the
    // left column or the top row.
    const bool half_width = picture.chroma_width < picture.width, half_height = picture.chroma_height < picture.height;
    const bool on_left = half_width && picture.siting != YuvView::Siting::centre;
    const bool on_top = half_height && picture.siting == YuvView::Siting::top_left;
    const float across = float(picture.width) / float((half_width ? 2 : 1) * picture.chroma_width);
    const float down = float(picture.height) / float((half_height ? 2 : 1) * picture.chroma_height);
    chroma_place_ = {across, down, on_left ? 0.25f / float(picture.chroma_width) : 0.0f,
                     on_top ? 0.25f / float(picture.chroma_height) : 0.0f};
}

void Albedo::set(const Image& picture) {
    assert(picture.width > 0 && picture.height > 0);
    kind_ = Kind::rgb;
    const GLenum layout = picture.channels == 4 ? GL_RGBA : picture.channels == 3 ? GL_RGB : GL_RED;
    allocate(picture_, picture.width, picture.height, GL_SRGB8_ALPHA8);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    std::vector<std::uint8_t> grey;
    const std::uint8_t* pixels = picture.pixels.data();
    if (layout == GL_RED) {  // sRGB textures have no single-channel form
        for (const std::uint8_t v : picture.pixels) grey.insert(grey.end(), 3, v);
        pixels = grey.data();
    }
    glTextureSubImage2D(picture_.texture.id(), 0, 0, 0, picture.width, picture.height, layout == GL_RED ? GL_RGB : layout,
                        GL_UNSIGNED_BYTE, pixels);
    glGenerateTextureMipmap(picture_.texture.id());
}

void Albedo::apply(gl::Program& program) const {
    if (kind_ == Kind::rgb) glBindTextureUnit(0, picture_.texture.id());
    if (kind_ != Kind::yuv) return;
    glBindTextureUnit(0, luma_.texture.id());
    glBindTextureUnit(1, chroma_.texture.id());
    program.set("to_rgb", to_rgb_);
    program.set("yuv_offset", offset_);
    program.set("chroma_place", chroma_place_);
}

const char* Albedo::defines(Kind kind) {
    return kind == Kind::none ? "#define ALBEDO_NONE\n" : kind == Kind::rgb ? "#define ALBEDO_RGB\n" : kind == Kind::yuv ? "#define ALBEDO_YUV\n" : "#define ALBEDO_MAP\n";
}

}  // namespace mien::render
