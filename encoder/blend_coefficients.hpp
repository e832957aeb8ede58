#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "core/result.hpp"
#include "model/face_model.hpp"

namespace mien::encoder {

struct BlendOptions {
    int grid_points = 1400;        ///< evenly spread over the face
    double reach = 1.8;            ///< candidates lie within reach * (δ1 + δ2) / 2
    double same_direction = 0.8;   ///< cosine above which the farther of two dots goes
    int smoothing_passes = 2;
    double smoothing = 0.25;       ///< share of the neighbours' mean in one pass
};

/// Blend coefficients of every vertex of `neutral` for dots at `sites` (Guenter et al. 1998, section 4.2): dots within
/// reach on a grid over the face, weighted by 1 / distance, labels above and below the slits kept apart, a ring of still
/// dots around the face, two smoothing passes. Linings hang on the skin they grow from, lower teeth and tongue on the
/// chin. Vertices in `rigid` and eyeballs follow the head pose alone. Distances run along the skin, not through the air.
/// Errors: no skin, or fewer than four sites.
Result<model::BlendBase> blend_coefficients(const Mesh& neutral, const std::vector<Site>& sites,
                                            const std::vector<std::uint32_t>& rigid, const BlendOptions& options = {});

}  // namespace mien::encoder
