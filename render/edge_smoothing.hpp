#pragma once

#include <Eigen/Geometry>
#include <cstdint>

namespace mien::render {

/// Anti-aliasing of a finished picture on the CPU: where brightness has an edge, blends along it. The idea of FXAA (Lottes
/// 2009), cut down to its short form, on encoded values, as the eye works. On the CPU, because a software renderer computes
/// every pixel as if it had an edge.
/// `drawn`, `smoothed`: width x height pixels of four bytes RGBA; edges are looked for within `pixels` alone.
void smooth_edges(const std::uint8_t* drawn, int width, int height, const Eigen::AlignedBox2i& pixels, std::uint8_t* smoothed);

}  // namespace mien::render
