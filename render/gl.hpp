#pragma once

#include <epoxy/gl.h>

#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/geometry.hpp"

/// Owning handles over OpenGL names, for the sources of this room only. Each needs its context current when created,
/// used and destroyed.
namespace mien::render::gl {

/// Owns one OpenGL name; Delete frees it. Name 0 is "none".
template <auto Delete>
class Name {
public:
    Name() = default;
    explicit Name(GLuint id) : id_(id) {}
    ~Name() { reset(); }
    Name(Name&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    Name& operator=(Name&& other) noexcept { return std::swap(id_, other.id_), *this; }
    GLuint id() const { return id_; }
    explicit operator bool() const { return id_ != 0; }
    void reset() {
        if (id_) Delete(std::exchange(id_, 0));
    }

private:
    GLuint id_ = 0;
};

inline void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }
inline void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
inline void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }
inline void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
inline void delete_renderbuffer(GLuint id) { glDeleteRenderbuffers(1, &id); }
inline void delete_program(GLuint id) { glDeleteProgram(id); }

using Buffer = Name<delete_buffer>;
using Texture = Name<delete_texture>;
using VertexArray = Name<delete_vertex_array>;
using Framebuffer = Name<delete_framebuffer>;
using Renderbuffer = Name<delete_renderbuffer>;

/// A buffer of `bytes` bytes; `content` null leaves it undefined. At least 16 bytes, so that it can always be bound.
Buffer make_buffer(std::size_t bytes, const void* content = nullptr);
Texture make_texture(GLenum target);
/// A buffer as shaders fetch it by the texel, of 32-bit channels. In software that is a load for each, where storage blocks take
/// one for each number. Throws EnvironmentError when it has more texels than the driver can fetch.
Texture make_texels(GLenum format, const Buffer& buffer);
VertexArray make_vertex_array();
Framebuffer make_framebuffer();
Renderbuffer make_renderbuffer();

/// A linked program; uniforms are set by name. Names the shader leaves out are ignored, because variants of one source
/// use different ones.
class Program {
public:
    Program() = default;
    void use() const { glUseProgram(program_.id()); }
    void set(const char* name, int value);
    void set(const char* name, float value);
    void set(const char* name, const Vec2& value);
    void set(const char* name, const Vec3& value);
    void set(const char* name, const Eigen::Vector4f& value);
    void set(const char* name, const Eigen::Matrix3f& value);
    void set(const char* name, const Eigen::Matrix4f& value);

private:
    friend Program make_program(std::string_view, std::string_view, std::string_view);
    friend Program make_compute(std::string_view, std::string_view);
    GLint location(const char* name);

    Name<delete_program> program_;
    std::unordered_map<std::string, GLint> locations_;
};

/// `defines` goes between the #version line and the rest of both sources. A shader that does not compile is a mistake of
/// ours or of the driver: throws EnvironmentError with the log.
Program make_program(std::string_view vertex, std::string_view fragment, std::string_view defines = {});
Program make_compute(std::string_view source, std::string_view defines = {});

}  // namespace mien::render::gl
