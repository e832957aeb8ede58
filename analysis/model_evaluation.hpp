#pragma once

#include <memory>

#include "analysis/evaluation.hpp"
#include "model/face_model.hpp"

namespace mien::analysis {

/// One layer of one frame, [channel][texel] of its domain. mm in head space, mm along the normal, or linear albedo.
struct LayerValues {
    std::vector<float> truth;   ///< of the scan, NaN: not seen
    std::vector<float> still;   ///< the model's layer as it is at rest: a static map (Ma et al. 2008, Figure 7)
    std::vector<float> model;   ///< the model's layer as the frame's markers move it
};
struct ModelFrame {
    Points base;                ///< V x 3 mm, head space
    LayerValues layers[3];      ///< medium, fine, albedo; empty where the model or the clip has none
};

/// A model on a clip with scans: both in the same words, frame by frame. Refers to both.
class ModelOnClip {
public:
    /// `face` has detail, and markers drive it, as many as the clip's; offsets count from the clip's own markers at rest where it says where they
    /// sit on its neutral mesh, else from the model's. The fine layer is measured over the medium surface as scanned, by what
    /// `high_pass_mm` lets through. Errors: what is missing, by name.
    static Result<ModelOnClip> create(const model::FaceModel& face, const Clip& clip, double high_pass_mm);
    ModelOnClip(ModelOnClip&&) noexcept;
    ~ModelOnClip();

    bool has(int layer) const;   ///< 0 medium, 1 fine, 2 albedo
    const model::DomainMap& domain(int layer) const;
    /// Errors: those of the scans. May be called from several threads at once.
    Result<ModelFrame> frame(std::int64_t frame) const;

private:
    struct State;
    explicit ModelOnClip(std::unique_ptr<const State> state);
    std::unique_ptr<const State> state_;
};

/// What a model leaves of the scans, layer by layer: of the layer moved, held still, and left out.
struct ModelEvaluation {
    struct Layer {
        std::string name;     ///< "medium" (mm, 3-D), "fine" (mm, along the normal), "albedo" (linear, mean of the channels)
        ErrorSummary none, still, model;
    };
    std::int64_t frames = 0;
    std::vector<Layer> layers;   ///< those that both model and clip have
};

/// Every `stride`-th frame.
Result<ModelEvaluation> evaluate_model(const ModelOnClip& pair, std::int64_t frames, std::int64_t stride = 1, const Progress& progress = {});

}  // namespace mien::analysis
