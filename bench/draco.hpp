#pragma once

#include <string>

#include "bench/geometry_codec.hpp"

namespace mien::bench {

std::string draco_library();  ///< "Draco 1.5.5"

// The three ways Draco can carry motion, one file each.
std::unique_ptr<GeometryCodec> draco_mesh_codec(bool best);
std::unique_ptr<GeometryCodec> draco_delta_codec();
std::unique_ptr<GeometryCodec> draco_animation_codec();

}  // namespace mien::bench
