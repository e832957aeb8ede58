#pragma once

namespace mien::render {

/// Which of the model's steps take part; the player's layer keys.
struct ShapeSteps {
    bool motion = true;   ///< mean + components * w
    bool medium = true;   ///< displacement of a detail model
    bool gaze = true;
    bool pose = true;
    bool operator==(const ShapeSteps&) const = default;
};

}  // namespace mien::render
