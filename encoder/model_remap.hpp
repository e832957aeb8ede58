#pragma once

#include "core/mesh.hpp"
#include "encoder/model_encoder.hpp"

namespace mien::encoder {

/// A trained model (mien train) that other markers drive, in the same session or another. Its base shape is formed from them; its detail stays as
/// it is, measured on that shape where the trained markers sit, so that neither axes nor strains need rescaling for another
/// density (Ma et al. 2008, section 5, rescale E), and all its blobs keep their names: who has them fetches some kilobytes.
/// sites: of the markers on the model's mesh; rest: M x 3 mm, the markers at rest in the model's space.
/// Errors: no thin shell; fewer than 4 or too many markers; a marker farther than coding::kMaxRestOffset from its site.
Result<EncodedModel> remap_markers(const EncodedModel& model, const std::vector<Site>& sites, PointsRef rest);

}  // namespace mien::encoder
