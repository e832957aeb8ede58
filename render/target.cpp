#include "render/target.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <vector>

#include "core/environment_error.hpp"
#include "render/context.hpp"
#include "render/edge_smoothing.hpp"
#include "render/gl.hpp"

namespace mien::render {

struct Target::State {
    int width = 0, height = 0, scale = 1;
    Smoothing smoothing = Smoothing::none;
    gl::Framebuffer drawn, resolved;
    gl::Renderbuffer colour, depth, resolved_colour;
    gl::Texture smoothed_colour;                  // Smoothing::edges
    std::vector<std::uint8_t> pixels, smoothed;   // of Smoothing::edges, RGBA from the lower left
    Eigen::AlignedBox2i edge_box;

    void read_drawn(GLuint framebuffer) {
        // Four channels are the framebuffer's own layout.
        pixels.resize(std::size_t(width) * std::size_t(height) * 4);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
        glPixelStorei(GL_PACK_ALIGNMENT, 4);
        glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    }

    void smooth() {
        read_drawn(drawn.id());
        smoothed.resize(pixels.size());
        smooth_edges(pixels.data(), width, height, edge_box, smoothed.data());
    }

    /// The framebuffer that holds the finished picture.
    GLuint finish() {
        if (smoothing == Smoothing::none) return drawn.id();
        if (smoothing == Smoothing::edges) {
            smooth();
            glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
            glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
            glTextureSubImage2D(smoothed_colour.id(), 0, 0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, smoothed.data());
            return resolved.id();
        }
        glEnable(GL_FRAMEBUFFER_SRGB);   // samples are averaged as light
        glBlitNamedFramebuffer(drawn.id(), resolved.id(), 0, 0, width * scale, height * scale, 0, 0, width, height,
                               GL_COLOR_BUFFER_BIT, scale > 1 ? GL_LINEAR : GL_NEAREST);
        return resolved.id();
    }
};

Smoothing live_smoothing() { return is_software_renderer() ? Smoothing::edges : Smoothing::multisample; }

Target::Target(int width, int height, Smoothing smoothing) : state_(std::make_unique<State>()) {
    assert(width > 0 && height > 0);
    State& s = *state_;
    s.smoothing = smoothing;
    s.scale = smoothing == Smoothing::supersample ? 2 : 1;
    GLint most = 1, side = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &side);
    if (width > side / s.scale || height > side / s.scale)
        throw EnvironmentError("the picture is larger than this OpenGL driver can draw");
    s.width = width;
    s.height = height;
    const int samples = smoothing == Smoothing::multisample ? std::min(4, int(most)) : 0;
    s.drawn = gl::make_framebuffer();
    s.colour = gl::make_renderbuffer();
    glNamedRenderbufferStorageMultisample(s.colour.id(), samples, GL_SRGB8_ALPHA8, width * s.scale, height * s.scale);
    glNamedFramebufferRenderbuffer(s.drawn.id(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, s.colour.id());
    s.depth = gl::make_renderbuffer();
    glNamedRenderbufferStorageMultisample(s.depth.id(), samples, GL_DEPTH_COMPONENT24, width * s.scale, height * s.scale);
    glNamedFramebufferRenderbuffer(s.drawn.id(), GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, s.depth.id());
    if (smoothing == Smoothing::edges) {
        s.resolved = gl::make_framebuffer();
        s.smoothed_colour = gl::make_texture(GL_TEXTURE_2D);
        glTextureStorage2D(s.smoothed_colour.id(), 1, GL_SRGB8_ALPHA8, width, height);
        glNamedFramebufferTexture(s.resolved.id(), GL_COLOR_ATTACHMENT0, s.smoothed_colour.id(), 0);
    } else if (smoothing != Smoothing::none) {
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
Smoothing Target::smoothing() const { return state_->smoothing; }

void Target::bind() const {
    glBindFramebuffer(GL_FRAMEBUFFER, state_->drawn.id());
    glViewport(0, 0, state_->width * state_->scale, state_->height * state_->scale);
}

void Target::edges_within(const Eigen::AlignedBox2i& pixels) {
    state_->edge_box = pixels.intersection({Eigen::Vector2i::Zero(), Eigen::Vector2i(width(), height())});
}

void Target::clear() {
    bind();
    edges_within({});
    glEnable(GL_FRAMEBUFFER_SRGB);
    glClearColor(0.02f, 0.02f, 0.02f, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

Image Target::read() {
    State& s = *state_;
    if (s.smoothing == Smoothing::edges) s.smooth();
    else s.read_drawn(s.finish());
    const std::vector<std::uint8_t>& rgba = s.smoothing == Smoothing::edges ? s.smoothed : s.pixels;
    // Dropping the fourth channel here is faster than in the driver.
    Image image(s.width, s.height, 3);
    for (int y = 0; y < s.height; ++y) {
        const std::uint8_t* in = rgba.data() + std::size_t(s.height - 1 - y) * s.width * 4;
        std::uint8_t* out = image.at(0, y);
        for (int x = 0; x < s.width; ++x, in += 4, out += 3) {
            out[0] = in[0];
            out[1] = in[1];
            out[2] = in[2];
        }
    }
    return image;
}

void Target::wait() {
    state_->finish();
    glFinish();
}

void Target::present(int window_width, int window_height) {
    State& s = *state_;
    const GLuint source = s.finish();
    glDisable(GL_FRAMEBUFFER_SRGB);   // the window takes encoded values as they are
    // Cleared first: some drivers notice a new size of the window at the first drawing and drop what was copied before.
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, window_width, window_height);
    glClear(GL_COLOR_BUFFER_BIT);
    const bool same = window_width == s.width && window_height == s.height;
    glBlitNamedFramebuffer(source, 0, 0, 0, s.width, s.height, 0, 0, window_width, window_height, GL_COLOR_BUFFER_BIT,
                           same ? GL_NEAREST : GL_LINEAR);
}

}  // namespace mien::render
