#pragma once

#include <string>
#include <vector>

#include "analysis/training.hpp"

namespace mien::analysis {

/// Mean, 99th percentile and maximum of many errors in constant memory: bins a fortieth of an octave wide, so that the percentile is
/// good to 2 %.
class ErrorSummary {
public:
    void add(double error);
    void merge(const ErrorSummary& other);
    double mean() const { return count_ ? sum_ / double(count_) : 0; }
    double maximum() const { return most_; }
    double percentile(double share) const;  ///< share: 0 .. 1
    std::int64_t count() const { return count_; }

private:
    std::vector<std::int64_t> bins_;
    std::int64_t count_ = 0;
    double sum_ = 0, most_ = 0;
};

/// Errors of one way to explain a layer over a clip: 3-D distance of the medium surface, distance along the normal of the fine one,
/// mean absolute difference of linear albedo over the three channels.
struct LayerErrors {
    std::string name;          ///< "base", "neutral", "linear", "biquadratic", "bicubic", "deformation", "global"
    ErrorSummary errors;
    std::vector<float> mean;   ///< [texels] over the frames; NaN: never seen
};

struct Evaluation {
    std::int64_t frames = 0;
    std::vector<LayerErrors> medium, fine, albedo;  ///< albedo empty when there is none
};

/// Compares all fitted ways of a model that was trained with `rivals` against the scans of a clip; every `stride`-th frame. The fine
/// layer's target is the same for all: what the model's own medium layer leaves. "base": nothing on top of the thin shell.
Result<Evaluation> evaluate_clip(const TrainedModel& trained, const Clip& clip, std::int64_t stride = 1, const Progress& progress = {});

}  // namespace mien::analysis
