#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image.hpp"
#include "core/mesh.hpp"
#include "core/rational.hpp"
#include "core/scan.hpp"

namespace mien {

/// F frames of N points each, mm, in the clip's space (head pose included). A missing marker is three NaNs.
struct PointSequence {
    std::int64_t frames = 0;
    std::int64_t points = 0;
    std::vector<float> xyz;  ///< F * N * 3

    PointSequence() = default;
    PointSequence(std::int64_t F, std::int64_t N) : frames(F), points(N), xyz(std::size_t(F * N * 3)) {}
    PointsMap frame(std::int64_t f) { return {xyz.data() + f * points * 3, points, 3}; }
    ConstPointsMap frame(std::int64_t f) const { return {xyz.data() + f * points * 3, points, 3}; }
};

/// F frames of n_b blendshape weights, unitless.
struct WeightSequence {
    std::int64_t frames = 0;
    std::int64_t count = 0;
    std::vector<float> values;        ///< F * n_b
    std::vector<std::string> names;   ///< n_b, or empty when nobody named them

    WeightSequence() = default;
    WeightSequence(std::int64_t F, std::int64_t n) : frames(F), count(n), values(std::size_t(F * n)) {}
    float* frame(std::int64_t f) { return values.data() + f * count; }
    const float* frame(std::int64_t f) const { return values.data() + f * count; }
};

/// One target of a blendshape rig: offsets from neutral at weight 1.
struct Blendshape {
    std::string name;
    Points offsets;  ///< V x 3, mm
};

enum class Unit : std::uint8_t { mm = 0, cm = 1, m = 2 };
constexpr double millimetres(Unit unit) { return unit == Unit::mm ? 1.0 : unit == Unit::cm ? 10.0 : 1000.0; }
constexpr const char* name_of(Unit unit) { return unit == Unit::mm ? "mm" : unit == Unit::cm ? "cm" : "m"; }

/// A captured performance in memory: what a clip folder (docs/clip.md) holds. All lengths in mm, whatever `unit` the
/// files had. At least one of vertices, markers, weights is present; all that are present have frame_count() frames.
struct Clip {
    std::string name;                    ///< of the folder
    Rational frame_rate{30, 1};          ///< frames per second
    Unit unit = Unit::mm;                ///< of the files; decode writes it back
    std::optional<Mesh> neutral;
    std::optional<PointSequence> vertices;
    std::optional<PointSequence> markers;
    std::vector<Site> marker_sites;      ///< one per marker, on `neutral`; or empty
    std::optional<WeightSequence> weights;
    std::vector<Blendshape> blendshapes; ///< one per weight, in weight order; or empty
    std::vector<std::uint32_t> rigid;    ///< vertices (markers, when there are no vertices) that move with the skull; may be empty
    std::vector<RigidPose> head_pose;    ///< known head pose per frame, or empty
    std::vector<Gaze> gaze;              ///< per frame, or empty
    std::shared_ptr<TextureSource> texture;  ///< null when there is none; one frame only means a static texture
    std::optional<Image> mask;           ///< grey; texels that are part of the face are > 0
    std::optional<Sound> sound;
    std::shared_ptr<const ScanSource> scans;  ///< one per frame; null when there are none
    std::vector<Take> takes;             ///< ascending, the first at frame 0; or empty: all one

    std::int64_t frame_count() const {
        return vertices ? vertices->frames : markers ? markers->frames : weights ? weights->frames : 0;
    }
};

}  // namespace mien
