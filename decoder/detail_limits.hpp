#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.hpp"
#include "core/result.hpp"

/// What a detail model may ask of whoever loads it: work and memory are bounded before they are begun.
namespace mien::decoder {

/// Skin that a thin shell of M markers can be solved on, and that distances are found along: as many vertices and triangles as scanned
/// faces have, few hubs, and a surface rather than a tangle (handles and edges of more than two triangles fill the solver's memory).
Result<void> check_skin(const Mesh& mesh, std::size_t markers);

/// Texels that finding out what covers them touches, and marker triangles that each is looked for in.
Result<void> check_domain(const Mesh& mesh, const std::vector<Triangle>& marker_triangles, std::size_t markers, int width, int height, std::uint64_t texels);

/// Whether so many bytes can hold so many coefficients or texels: none costs nothing, so that no small blob announces a large map.
bool plausible(std::uint64_t values, std::size_t bytes);

}  // namespace mien::decoder
