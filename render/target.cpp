#include "render/target.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "core/environment_error.hpp"
#include "render/gl.hpp"

namespace mien::render {

struct Target::State {
    int width = 0, height = 0, samples = 1;
    gl::Framebuffer drawn, resolved;      // `resolved` only when multisampled
    gl::Renderbuffer colour, depth, resolved_colour;

    GLuint resolve() {
        if (samples == 1) return drawn.id();
        glBlitNamedFramebuffer(drawn.id(), resolved.id(), 0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                               GL_NEAREST);
        return resolved.id();
    }
};

Target::Target(int width, int height, int samples) : state_(std::make_unique<State>()) {
    assert(width > 0 && height > 0 && samples > 0);
    State& s = *state_;
    GLint most = 1, side = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &side);
    if (width > side || height > side) throw EnvironmentError("the picture is larger than this OpenGL driver can draw");
    s.width = width;
    s.height = height;
    s.samples = std::clamp(samples, 1, std::max(1, int(most)));
    const int stored = s.samples == 1 ? 0 : s.samples;
    s.colour = gl::make_renderbuffer();
    s.depth = gl::make_renderbuffer();
    s.drawn = gl::make_framebuffer();
    glNamedRenderbufferStorageMultisample(s.colour.id(), stored, GL_SRGB8_ALPHA8, width, height);
    glNamedRenderbufferStorageMultisample(s.depth.id(), stored, GL_DEPTH_COMPONENT24, width, height);
    glNamedFramebufferRenderbuffer(s.drawn.id(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, s.colour.id());
    glNamedFramebufferRenderbuffer(s.drawn.id(), GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, s.depth.id());
    if (s.samples > 1) {
        s.resolved = gl::make_framebuffer();
        s.resolved_colour = gl::make_renderbuffer();
        glNamedRenderbufferStorage(s.resolved_colour.id(), GL_SRGB8_ALPHA8, width, height);
        glNamedFramebufferRenderbuffer(s.resolved.id(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, s.resolved_colour.id());
    }
    if (glCheckNamedFramebufferStatus(s.drawn.id(), GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw EnvironmentError("this OpenGL driver cannot make a picture of this size; try a smaller one");
}

Target::Target(Target&&) noexcept = default;
Target& Target::operator=(Target&&) noexcept = default;
Target::~Target() = default;

int Target::width() const { return state_->width; }
int Target::height() const { return state_->height; }
int Target::samples() const { return state_->samples; }

void Target::bind() const {
    glBindFramebuffer(GL_FRAMEBUFFER, state_->drawn.id());
    glViewport(0, 0, state_->width, state_->height);
}

Image Target::read() {
    const State& s = *state_;
    // A resolve converts to linear and back when sRGB is on; reading never does.
    glEnable(GL_FRAMEBUFFER_SRGB);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, state_->resolve());
    Image bottom_up(s.width, s.height, 3), image(s.width, s.height, 3);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, s.width, s.height, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.pixels.data());
    for (int y = 0; y < s.height; ++y)
        std::memcpy(image.at(0, y), bottom_up.at(0, s.height - 1 - y), std::size_t(s.width) * 3);
    return image;
}

void Target::present(int window_width, int window_height) {
    const State& s = *state_;
    const GLuint source = state_->resolve();
    // The window's framebuffer takes encoded values as they are: both ends count as linear for this copy.
    glDisable(GL_FRAMEBUFFER_SRGB);
    const bool same = window_width == s.width && window_height == s.height;
    glBlitNamedFramebuffer(source, 0, 0, 0, s.width, s.height, 0, 0, window_width, window_height, GL_COLOR_BUFFER_BIT,
                           same ? GL_NEAREST : GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, window_width, window_height);
}

}  // namespace mien::render
