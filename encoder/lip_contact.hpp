#pragma once

#include <optional>

#include "core/mesh.hpp"
#include "model/contact.hpp"

namespace mien::encoder {

/// The contact of the lips of a neutral head: pairs are vertices of the two lips that are each other's nearest, members
/// the skin around the slit of the mouth and the lining next to it. None without a mouth (find_slits).
std::optional<model::Contact> lip_contact(const Mesh& neutral);

}  // namespace mien::encoder
