#include "render/target.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "core/environment_error.hpp"
#include "embedded_mien_render.hpp"
#include "render/context.hpp"
#include "render/gl.hpp"

namespace mien::render {

struct Target::State {
    int width = 0, height = 0, scale = 1;
    Smoothing smoothing = Smoothing::none;
    gl::Framebuffer drawn, resolved;
    gl::Renderbuffer colour, depth, resolved_colour;
    gl::Texture colour_texture, colour_encoded;   // Smoothing::edges: the drawn picture, and its bytes as they are
    gl::Program edges;
    Eigen::AlignedBox2i edge_box;
    gl::VertexArray any;

    void attach_colour(int samples) {
        const int w = width * scale, h = height * scale;
        if (smoothing == Smoothing::edges) {
            colour_texture = gl::make_texture(GL_TEXTURE_2D);
            glTextureStorage2D(colour_texture.id(), 1, GL_SRGB8_ALPHA8, w, h);
            glNamedFramebufferTexture(drawn.id(), GL_COLOR_ATTACHMENT0, colour_texture.id(), 0);
            GLuint view = 0;
            glGenTextures(1, &view);
            colour_encoded = gl::Texture(view);
            glTextureView(view, GL_TEXTURE_2D, colour_texture.id(), GL_RGBA8, 0, 1, 0, 1);
            glTextureParameteri(view, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
            glTextureParameteri(view, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
            glTextureParameteri(view, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
            edges = gl::make_program(embedded::shaders_whole_vert, embedded::shaders_smooth_edges_frag);
            any = gl::make_vertex_array();
        } else {
            colour = gl::make_renderbuffer();
            glNamedRenderbufferStorageMultisample(colour.id(), samples, GL_SRGB8_ALPHA8, w, h);
            glNamedFramebufferRenderbuffer(drawn.id(), GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour.id());
        }
    }

    /// The framebuffer that holds the finished picture.
    GLuint finish() {
        if (smoothing == Smoothing::none) return drawn.id();
        if (smoothing == Smoothing::edges) {
            glCopyImageSubData(colour_texture.id(), GL_TEXTURE_2D, 0, 0, 0, 0, resolved_colour.id(), GL_RENDERBUFFER, 0, 0, 0, 0,
                               width, height, 1);
            if (edge_box.isEmpty()) return resolved.id();
            glBindFramebuffer(GL_FRAMEBUFFER, resolved.id());
            glViewport(0, 0, width, height);
            const Eigen::Vector2i size = edge_box.sizes();
            glEnable(GL_SCISSOR_TEST);
            glScissor(edge_box.min().x(), edge_box.min().y(), size.x(), size.y());
            glDisable(GL_FRAMEBUFFER_SRGB);   // the bytes are encoded already
            glDisable(GL_DEPTH_TEST);
            glDisable(GL_BLEND);
            glBindTextureUnit(0, colour_encoded.id());
            edges.use();
            glBindVertexArray(any.id());
            glDrawArrays(GL_TRIANGLES, 0, 3);
            glDisable(GL_SCISSOR_TEST);
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
    s.attach_colour(samples);
    s.depth = gl::make_renderbuffer();
    glNamedRenderbufferStorageMultisample(s.depth.id(), samples, GL_DEPTH_COMPONENT24, width * s.scale, height * s.scale);
    glNamedFramebufferRenderbuffer(s.drawn.id(), GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, s.depth.id());
    if (smoothing != Smoothing::none) {
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
    glBindFramebuffer(GL_READ_FRAMEBUFFER, s.finish());
    // Four channels are the framebuffer's own layout; dropping the fourth here is faster than in the driver.
    std::vector<std::uint8_t> rgba(std::size_t(s.width) * s.height * 4);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, s.width, s.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
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
