#pragma once

#include <memory>

#include "core/image.hpp"

namespace mien::render {

/// Where pictures are drawn: colour and depth, anti-aliased, of any size. Belongs to the current context.
class Target {
public:
    /// samples: 1, or the multisamples per pixel (clamped to what the driver has).
    Target(int width, int height, int samples = 4);
    Target(Target&&) noexcept;
    Target& operator=(Target&&) noexcept;
    ~Target();

    int width() const;
    int height() const;
    int samples() const;
    void bind() const;                                    ///< draw calls go here from now on
    Image read();                                         ///< RGB, sRGB-encoded, rows from the top
    /// Copies the picture into the window's own framebuffer, `width` x `height` pixels, without scaling when equal.
    void present(int window_width, int window_height);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::render
