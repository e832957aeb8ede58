#pragma once

#include <vector>

#include "core/mesh.hpp"
#include "model/contact.hpp"

namespace mien::encoder {

/// The contacts of a neutral head: of its lips, then of the lids of each eye. Of the mouth, pairs are vertices of the two lips that are
/// each other's nearest; of an eye, vertices of the two margins one over the other. Members are the skin around the slit and the lining
/// next to it. Slits that the mesh does not show (find_slits) have none.
std::vector<model::Contact> find_contacts(const Mesh& neutral);

}  // namespace mien::encoder
