#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coding/point_order.hpp"
#include "core/hash.hpp"
#include "core/result.hpp"

namespace mien::coding {

/// How the frames of a stream are coded. transform: cosine transforms inside a group. causal: predicted from the past, one
/// object per frame. guenter98: the 1998 paper's order-1 prediction with static codes.
enum class MotionScheme : std::uint8_t { transform = 1, causal = 2, guenter98 = 3 };

/// What is known of a motion track before its basis is read.
struct MotionShape {
    std::uint32_t points = 0;         ///< vertices, markers or weights
    std::uint32_t coordinates = 3;    ///< 3, or 1 for weights
    bool pose = false, gaze = false, presence = false;

    std::uint64_t dimension() const { return std::uint64_t(points) * coordinates; }
    int side_channels() const { return (pose ? 6 : 0) + (gaze ? 4 : 0); }
};

/// Starting state of the entropy coder of the frames: chances per context, mixer weights. What is not sent is neutral.
struct MotionStart {
    struct Chance {
        std::uint32_t at = 0;         ///< entry of IntegerModel::bits()
        std::int8_t level = 0;        ///< logit in units of kLevelUnit / 256
    };
    static constexpr int kLevelUnit = 96;
    std::vector<Chance> chances;      ///< ascending
    std::uint8_t confidence = 0;      ///< how many observations a stored chance counts for
    std::vector<std::int8_t> weights; ///< mixer weights in 1/32; empty: neutral
};

/// A motion basis as it is stored: integers and steps. The motion vector is
/// x = mean_step * mean + sum_j column_j * w_j, where column_j is the integer vector components[j] brought to the length
/// `step` / 16 and w_j counts sixteenths of a step; so a decoded coefficient has the same meaning however coarsely its
/// vector was quantised.
struct MotionBasis {
    static constexpr int kFraction = 16;            ///< decoded coefficients count step / kFraction
    static constexpr std::uint32_t kMaxComponents = 4096;
    static constexpr std::uint64_t kMaxValues = 1u << 26;   ///< components x dimension: 64 M, a 26 000-vertex head with 800
    static constexpr int kMaxOrder = 3;

    /// Vectors count 32nds of a step; where points have no levels every residual counts whole ones.
    static constexpr std::array<std::uint8_t, PointOrder::kLevels> kEvenSteps{32, 32, 32, 32, 32, 32, 32, 32};

    MotionScheme scheme = MotionScheme::transform;
    float step = 1;                                 ///< of coefficients, mm over all points (orthonormal vectors)
    float mean_step = 1;                            ///< mm or weight units per unit of `mean`
    std::vector<std::int32_t> mean;                 ///< d
    std::vector<std::vector<std::int32_t>> components;  ///< k vectors of d
    bool refines = false;                           ///< of a rung that refines another
    std::uint32_t shared = 0;                       ///< the first so many components are those of the rung below, not stored again

    float translation_step = 1;                     ///< mm
    float rotation_step = 1;                        ///< radians
    float gaze_step = 1;                            ///< radians
    std::array<float, 3> centre{};                  ///< the head turns about this point, mm, head space
    std::array<std::int32_t, 10> side_mean{};       ///< of pose (translation, rotation vector) and gaze, in steps

    std::uint8_t block = 32;                        ///< transform: longest block, frames
    std::vector<std::array<std::int16_t, kMaxOrder>> predictors;  ///< causal: per channel, in 1/256, nearest past first
    bool across_mesh = false;                       ///< components are predicted over the triangles of the neutral mesh
    bool mirrored = false;                          ///< ... and from one side of the face to the other
    std::vector<std::uint32_t> parents;             ///< or over these earlier points; empty: not predicted
    std::array<std::uint8_t, PointOrder::kLevels> level_steps = kEvenSteps;  ///< residual step by level
    std::vector<std::uint32_t> corrected;           ///< points (weights) that MotionCorrections corrects, ascending
    float correction_step = 1;                      ///< mm or weight units
    MotionStart start;
    /// guenter98: chances of every bin as logit levels, one row per channel, then one per basis vector.
    std::vector<std::array<std::int8_t, 24>> static_codes;

    std::uint32_t size() const { return std::uint32_t(components.size()); }
    int channels(const MotionShape& shape) const { return shape.side_channels() + int(size()); }
};

/// Bytes of a basis and how many of them are probabilities.
struct BasisBytes {
    Bytes bytes;
    std::size_t probabilities = 0;
};

/// The order in which `basis` codes its points. `triangles` and `mirror`: of the neutral mesh, used when across_mesh and mirrored.
PointOrder basis_order(const MotionBasis& basis, const MotionShape& shape, std::span<const Triangle> triangles,
                       std::span<const std::uint32_t> mirror);

/// Writes a basis. Its vectors must lie on the residual grid that VectorQuantiser makes.
BasisBytes write_motion_basis(const MotionBasis& basis, const MotionShape& shape, const PointOrder& order);

/// What a rung that refines `below` has in common with it: scheme, block length, the order of points, all its components.
MotionBasis refining(const MotionBasis& below);

/// Reads a basis; refuses what cannot be, and one that is predicted across a mesh when `triangles` is empty, or from side to
/// side when `mirror` (Mesh::mirror) is. `below`: the basis of the rung that this one refines; none: it stands alone.
Result<MotionBasis> read_motion_basis(const MotionShape& shape, ByteView bytes, std::span<const Triangle> triangles,
                                      std::span<const std::uint32_t> mirror = {}, const MotionBasis* below = nullptr);

/// How many bytes of a basis are probabilities, from its head alone.
Result<std::size_t> motion_basis_probabilities(ByteView bytes);

}  // namespace mien::coding
