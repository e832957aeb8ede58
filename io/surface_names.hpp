#pragma once

#include <optional>
#include <string_view>

#include "core/mesh.hpp"

namespace mien::io {

/// What a material, group or object name says about its surface ("M_GumsTongue" -> mouth, "Sclera_L" -> eye); nothing when
/// the name tells nothing ("lambert2").
std::optional<Surface> surface_from_name(std::string_view name);

/// "skin", "eye", "cornea", "teeth", "mouth", "lashes", "hair", "other".
const char* name_of(Surface surface);

}  // namespace mien::io
