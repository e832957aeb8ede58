#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "model/lid.hpp"

namespace mien::encoder {

/// The upper lids of a neutral head, for markers at `sites` on it. A lid's way is taken to fall in proportion to the distance along the skin
/// from its margin to its fold, and from the middle to the corners as the eye opens less. None of eyes that are closed or have no marker
/// on their upper lid.
std::vector<model::Lid> find_lids(const Mesh& neutral, const std::vector<Site>& sites);

}  // namespace mien::encoder
