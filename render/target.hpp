#pragma once

#include <Eigen/Geometry>
#include <memory>

#include "core/image.hpp"

namespace mien::render {

/// How edges are made smooth, from cheap to dear on a CPU.
enum class Smoothing {
    none,
    edges,         ///< blends along edges of the finished picture, on the CPU: a few ms
    multisample,   ///< four samples of coverage per pixel: cheap on a GPU, four times the frame on a CPU
    supersample,   ///< drawn at twice the size each way: for stills
};

/// edges in software, multisample on a GPU. Of the current context.
Smoothing live_smoothing();

/// Where pictures are drawn: colour and depth, of any size. Belongs to the current context.
class Target {
public:
    /// Throws EnvironmentError when the driver cannot make a picture that large.
    Target(int width, int height, Smoothing smoothing);
    Target(Target&&) noexcept;
    Target& operator=(Target&&) noexcept;
    ~Target();

    int width() const;      ///< of the picture that comes out
    int height() const;
    Smoothing smoothing() const;
    void bind() const;      ///< draw calls go here from now on
    /// What is drawn next has its edges in here: pixels, from the lower left. Smoothing::edges looks nowhere else.
    void edges_within(const Eigen::AlignedBox2i& pixels);
    void clear();           ///< a picture of nothing: dark grey
    Image read();           ///< RGB, sRGB-encoded, rows from the top
    /// Finishes the picture and waits until it is there: for measuring.
    void wait();
    /// Copies the picture into the window's own framebuffer, without scaling when the sizes are equal.
    void present(int window_width, int window_height);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mien::render
