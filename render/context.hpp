#pragma once

#include <memory>
#include <string>

namespace mien::render {

/// An OpenGL 4.5 core context without a window, through EGL: Mesa's software rasteriser is enough. Current on the thread
/// that makes it, from construction to destruction; make_current() moves it to another.
class OffscreenContext {
public:
    /// Throws EnvironmentError, saying what to install, when no driver gives such a context.
    OffscreenContext();
    ~OffscreenContext();
    OffscreenContext(const OffscreenContext&) = delete;
    OffscreenContext& operator=(const OffscreenContext&) = delete;

    void make_current();
    void release();                       ///< no context is current on this thread afterwards

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The driver's own name for what draws, of the current context.
std::string renderer_name();
/// Whether the current context draws on the CPU, where shadows and anti-aliasing cost frames.
bool is_software_renderer();

}  // namespace mien::render
