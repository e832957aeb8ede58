#pragma once

#include <string>
#include <vector>

#include "analysis/evaluation.hpp"
#include "core/image.hpp"

namespace mien::analysis {

/// What a model that was trained with `rivals` leaves on one clip.
struct ClipEvaluation {
    std::string name;
    Evaluation evaluation;
};

/// The figures of a training as a page of Markdown tables: energy of the five axes (Ma et al. 2008, Table 1), strengths of the
/// ridges, then for every clip and layer mean, 99th percentile and maximum of every way to explain it (their Figure 5).
std::string report_markdown(const TrainedModel& trained, const std::vector<ClipEvaluation>& clips);
/// The same as JSON.
std::string report_json(const TrainedModel& trained, const std::vector<ClipEvaluation>& clips);

/// Mean errors over texture space, one square per way, left to right in the order of `layer`; black (none) over red and yellow to white
/// (`most` and above). Texels that no scan showed are grey-blue.
Image error_picture(const model::DomainMap& domain, const std::vector<LayerErrors>& layer, double most);

}  // namespace mien::analysis
