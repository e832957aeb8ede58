#pragma once

#include <string_view>
#include <vector>

#include "core/scan.hpp"
#include "samples/performance.hpp"

namespace mien::samples {

/// A training session (Ma et al. 2008, section 3): six expressions, each from neutral to its extreme, `frames_each` frames: brows
/// raised, brows knit, nose wrinkled, cheeks (smile), lips (frown, then pursed), jaw. `extra` frames of a range of motion, spread
/// evenly over it, follow as one more take; none when 0. The head stays still. frames_each >= 2.
struct TrainingSession {
    Performance performance;
    std::vector<Take> takes;
};
TrainingSession perform_training(int frames_each, int extra, std::uint64_t seed);

/// Performances no training session shows, `frames` long, by name: "asymmetric smile" (one corner, one cheek, one eye), "raised brow" (one
/// alone).
Performance perform_unseen(std::string_view name, int frames);
inline constexpr std::string_view kAsymmetricSmile = "asymmetric smile", kRaisedBrow = "raised brow";

}  // namespace mien::samples
