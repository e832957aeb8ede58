#include "render/gl.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/environment_error.hpp"

namespace mien::render::gl {
namespace {

GLuint compile(GLenum stage, std::string_view source, std::string_view defines) {
    const std::size_t body = source.find('\n') + 1;  // after #version
    const std::string text = fmt::format("{}{}\n#line 2\n{}", source.substr(0, body), defines, source.substr(body));
    const GLuint shader = glCreateShader(stage);
    const char* pointer = text.c_str();
    glShaderSource(shader, 1, &pointer, nullptr);
    glCompileShader(shader);
    return shader;
}

std::string log_of(GLuint program, std::initializer_list<GLuint> shaders) {
    std::string log;
    char text[4096];
    for (const GLuint shader : shaders) {
        glGetShaderInfoLog(shader, sizeof text, nullptr, text);
        log += text;
    }
    glGetProgramInfoLog(program, sizeof text, nullptr, text);
    return log + text;
}

GLuint link(std::initializer_list<GLuint> shaders) {
    const GLuint program = glCreateProgram();
    for (const GLuint shader : shaders) glAttachShader(program, shader);
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    const std::string log = linked ? "" : log_of(program, shaders);
    for (const GLuint shader : shaders) {
        glDetachShader(program, shader);
        glDeleteShader(shader);
    }
    if (linked) return program;
    glDeleteProgram(program);
    throw EnvironmentError(fmt::format("this OpenGL driver refuses a shader: {}", log));
}

}  // namespace

Buffer make_buffer(std::size_t bytes, const void* content) {
    GLuint id = 0;
    glCreateBuffers(1, &id);
    glNamedBufferStorage(id, std::max<std::size_t>(bytes, 16), bytes >= 16 ? content : nullptr, GL_DYNAMIC_STORAGE_BIT);
    if (bytes > 0 && bytes < 16 && content) glNamedBufferSubData(id, 0, bytes, content);
    return Buffer(id);
}

Texture make_texture(GLenum target) {
    GLuint id = 0;
    glCreateTextures(target, 1, &id);
    return Texture(id);
}

Texture make_texels(GLenum format, const Buffer& buffer) {
    GLint64 bytes = 0;
    GLint most = 0;
    glGetNamedBufferParameteri64v(buffer.id(), GL_BUFFER_SIZE, &bytes);
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
    const int channels = format == GL_RGBA32F ? 4 : format == GL_RGB32F ? 3 : format == GL_RG32UI ? 2 : 1;
    if (bytes / (4 * channels) > most) throw EnvironmentError("this OpenGL driver's buffers are too small for a mesh of this size");
    Texture texels = make_texture(GL_TEXTURE_BUFFER);
    glTextureBuffer(texels.id(), format, buffer.id());
    return texels;
}
VertexArray make_vertex_array() {
    GLuint id = 0;
    glCreateVertexArrays(1, &id);
    return VertexArray(id);
}
Framebuffer make_framebuffer() {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    return Framebuffer(id);
}
Renderbuffer make_renderbuffer() {
    GLuint id = 0;
    glCreateRenderbuffers(1, &id);
    return Renderbuffer(id);
}

GLint Program::location(const char* name) {
    const auto [at, fresh] = locations_.try_emplace(name, -1);
    if (fresh) at->second = glGetUniformLocation(program_.id(), name);
    return at->second;
}

void Program::set(const char* name, int value) { glProgramUniform1i(program_.id(), location(name), value); }
void Program::set(const char* name, float value) { glProgramUniform1f(program_.id(), location(name), value); }
void Program::set(const char* name, const Vec2& v) { glProgramUniform2fv(program_.id(), location(name), 1, v.data()); }
void Program::set(const char* name, const Vec3& v) { glProgramUniform3fv(program_.id(), location(name), 1, v.data()); }
void Program::set(const char* name, const Eigen::Vector4f& v) {
    glProgramUniform4fv(program_.id(), location(name), 1, v.data());
}
void Program::set(const char* name, const Eigen::Matrix3f& m) {
    glProgramUniformMatrix3fv(program_.id(), location(name), 1, GL_FALSE, m.data());
}
void Program::set(const char* name, const Eigen::Matrix4f& m) {
    glProgramUniformMatrix4fv(program_.id(), location(name), 1, GL_FALSE, m.data());
}

Program make_program(std::string_view vertex, std::string_view fragment, std::string_view defines) {
    Program program;
    program.program_ = decltype(program.program_)(
        link({compile(GL_VERTEX_SHADER, vertex, defines), compile(GL_FRAGMENT_SHADER, fragment, defines)}));
    return program;
}

Program make_compute(std::string_view source, std::string_view defines) {
    Program program;
    program.program_ = decltype(program.program_)(link({compile(GL_COMPUTE_SHADER, source, defines)}));
    return program;
}

}  // namespace mien::render::gl
