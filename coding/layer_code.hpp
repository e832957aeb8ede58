#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/clip.hpp"
#include "core/hash.hpp"
#include "core/result.hpp"

/// Layers of a face model beside its mesh, as bytes. docs/format-model.md gives them.
namespace mien::coding {

/// Sparse rows of shares: row j mixes the points `columns` by `shares` (Guenter et al. 1998: the blend coefficients a_jk).
struct SparseRows {
    struct Term {
        std::uint32_t column;
        float share;  ///< 0 .. 1
    };
    std::vector<std::uint32_t> row_start;  ///< rows + 1
    std::vector<Term> terms;               ///< ascending columns within a row
};

/// Shares are rounded to 1/255 so that each row keeps its sum to the nearest 1/255.
Bytes encode_blend(const std::vector<Site>& sites, const SparseRows& rows);
struct Blend {
    std::vector<Site> sites;
    SparseRows rows;
};
/// V: vertices of the mesh; there are as many rows.
Result<Blend> decode_blend(ByteView bytes, std::uint32_t V);

/// Targets on a grid of `step` mm, each predicted over the mesh.
Bytes encode_blendshapes(const std::vector<Blendshape>& targets, const std::vector<Triangle>& triangles, float step);
Result<std::vector<Blendshape>> decode_blendshapes(ByteView bytes, std::uint32_t V, const std::vector<Triangle>& triangles);

/// A ball of vertices with its centre, mm.
struct Ball {
    Vec3 centre = Vec3::Zero();
    std::vector<std::uint32_t> vertices;  ///< ascending
};
Bytes encode_eyes(const std::array<std::optional<Ball>, 2>& eyes);
Result<std::array<std::optional<Ball>, 2>> decode_eyes(ByteView bytes, std::uint32_t V);

/// Lips or lids that are held apart: facing vertices, and what is held on its own side of the surface between them.
struct Contact {
    struct Member {
        std::uint32_t vertex;
        float hold;  ///< share of the push, 0 < |hold| <= 1, negative below the surface; rounded to 1/127
    };
    std::vector<std::array<std::uint32_t, 2>> pairs;  ///< 1 to kMaxContactPairs
    std::vector<Member> members;                      ///< ascending vertices
};
inline constexpr std::size_t kMaxContactPairs = 256;
Bytes encode_contact(const Contact& contact);
Result<Contact> decode_contact(ByteView bytes, std::uint32_t V);

/// An upper lid that slides over its eyeball.
struct Lid {
    struct Member {
        std::uint32_t vertex;
        float share;   ///< of the lid's way, 0 .. 255/64; rounded to 1/64
        float weight;  ///< of that against the base shape's own, 0 .. 1; rounded to 1/255
        float hold;    ///< share of the way back to its distance from the centre, 0 .. 1; rounded to 1/255
    };
    Vec3 centre = Vec3::Zero();   ///< of the eyeball, mm
    std::vector<Member> members;  ///< ascending vertices
};
Bytes encode_lid(const Lid& lid);
Result<Lid> decode_lid(ByteView bytes, std::uint32_t V);

}  // namespace mien::coding
