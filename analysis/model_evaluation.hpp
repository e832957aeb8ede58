#pragma once

#include "analysis/evaluation.hpp"
#include "model/face_model.hpp"

namespace mien::analysis {

/// What a stored model leaves of the scans of a clip, layer by layer, as the plain model ("model") and as two that do not move their detail:
/// "none", the base shape alone (albedo: none), and "still", the layers as they are at rest: a static displacement map (Ma et al. 2008, Figure 7).
struct ModelEvaluation {
    struct Layer {
        std::string name;     ///< "medium" (mm, 3-D), "fine" (mm, along the normal), "albedo" (linear, mean of the channels)
        ErrorSummary none, still, model;
    };
    std::int64_t frames = 0;
    std::vector<Layer> layers;   ///< those that both model and clip have
};

/// Compares every `stride`-th frame. `face` has detail, and markers drive it, as many as the clip's; offsets count from the clip's own markers at rest
/// where it says where they sit on its neutral mesh, else from the model's. The fine layer is measured over the medium surface as scanned, by what
/// `high_pass_mm` lets through. Errors: what is missing, by name; those of the scans.
Result<ModelEvaluation> evaluate_model(const model::FaceModel& face, const Clip& clip, std::int64_t stride = 1, double high_pass_mm = 4, const Progress& progress = {});

}  // namespace mien::analysis
