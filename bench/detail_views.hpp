#pragma once

#include <string>
#include <vector>

#include "analysis/model_evaluation.hpp"
#include "bench/picture_score.hpp"

namespace mien::bench {

/// A trained model drawn beside its clip's scans, by one renderer: from three fixed cameras, inside the face's own pixels, layer by layer.
struct DetailViews {
    struct Row {
        std::string name;      ///< "base", "medium", "medium + fine", "all", "still"
        PictureScore score;
    };
    std::vector<Row> rows;
    std::vector<std::int64_t> frames;   ///< that were drawn
    Image sheet;               ///< the frame that moves most: truth and every row, left to right; from the front, then from the left
};

/// Draws `pictures` frames, evenly spread. "base": no medium, no fine layer, colours at rest; then one layer more in each row;
/// "still": all three as they are at rest, on the moving base. Texels that no scan showed have the model's own values in the truth.
/// Throws EnvironmentError without OpenGL.
Result<DetailViews> view_detail(const model::FaceModel& face, const analysis::ModelOnClip& pair, std::int64_t frames, std::int64_t pictures, const Progress& progress = {});

}  // namespace mien::bench
