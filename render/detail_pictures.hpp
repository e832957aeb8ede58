#pragma once

#include <array>
#include <vector>

#include "core/image.hpp"
#include "model/detail_layers.hpp"

namespace mien::render {

/// The maps of a detail model laid out as the GPU takes them. Made without OpenGL, so that one thread can do it while another draws.
struct DetailPictures {
    /// The fine and albedo maps in one size.
    struct Level {
        using Texel = std::array<float, 4>;
        Level(int w, int h, int terms);

        int width = 0, height = 0;
        std::vector<Texel> domain;                      ///< b1, b2, marker triangle or -1, share of the map against `still`
        std::vector<Texel> still;                       ///< linear colour of what no map covers; the last number is 0
        std::vector<std::vector<Texel>> coefficients;   ///< by term: albedo in three numbers, height in the last
    };
    std::vector<Level> maps;     ///< map_pictures(); empty: as they were
    std::vector<float> medium;   ///< medium_coefficients(); empty: as they were
};

/// The fine and albedo maps in their own size, in half of it, and so on; `model` has one of them. `still`: colour of what the albedo map does not
/// cover, the size does not matter; null: the map's own resting colours, spread out.
std::vector<DetailPictures::Level> map_pictures(const model::DetailModel& model, const Image* still);

/// What moves the vertices that have a place in the medium map, vertex after vertex: for each of its texels the terms, three channels each.
std::vector<float> medium_coefficients(const model::DetailModel& model, const model::MediumSurface& surface);

}  // namespace mien::render
