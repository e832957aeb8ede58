#pragma once

#include <string>
#include <vector>

struct GLFWwindow;

namespace mien::player {

/// Text and the time line over the picture, through Dear ImGui. Belongs to the window's OpenGL context.
class Overlay {
public:
    /// scale: pixels per point of the window (HiDPI).
    Overlay(GLFWwindow* window, float scale);
    ~Overlay();
    Overlay(const Overlay&) = delete;
    Overlay& operator=(const Overlay&) = delete;

    struct Content {
        std::vector<std::string> statistics;   ///< upper left; empty: none
        std::string message;                   ///< in the middle at the bottom; empty: none
        bool help = false;
        double time_line = -1;                 ///< 0 .. 1; negative: none
        std::string clock;                     ///< beside the time line
        bool live = false;                     ///< a sign in the lower right corner, instead of the time line
    };
    void draw(const Content& content);

private:
    float scale_;
};

}  // namespace mien::player
