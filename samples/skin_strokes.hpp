#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include "core/mesh.hpp"
#include "samples/noise.hpp"

namespace mien::samples {

/// Random places on some surfaces of a mesh, spread evenly by area.
class SurfaceSampler {
public:
    SurfaceSampler(const Mesh& mesh, std::uint32_t surfaces);  ///< bit s set: Surface(s) counts

    struct Place {
        Vec3 position, normal;
        Surface surface;
    };
    Place draw(Random& random) const;
    float area() const { return cumulative_.empty() ? 0 : cumulative_.back(); }  ///< mm^2

private:
    const Mesh& mesh_;
    Points normals_;
    std::vector<std::uint32_t> triangles_;
    std::vector<Surface> surfaces_;
    std::vector<float> cumulative_;
};

/// A hair lying on the skin, or a spot (a == b): a tapered arc, drawn in 3-D so that seams of the atlas do
/// not cut it.
struct Stroke {
    Vec3 a, b, c;                                  ///< root, middle, tip; mm
    Vec3 normal;                                   ///< of the skin below; distance along it does not count
    float radius_root = 0.2f, radius_tip = 0.05f;  ///< mm
    Vec3 tint;                                     ///< linear; see mode
    float opacity = 1;
    enum class Mode : std::uint8_t {
        cover,
        absorb
    } mode = Mode::cover;   ///< blend to `tint`, or multiply with it
    float softness = 0.1f;  ///< mm over which the edge fades
};

/// Many strokes, found by place.
class StrokeField {
public:
    void add(const Stroke& stroke);
    std::size_t size() const { return strokes_.size(); }

    /// Draws all strokes over a point of the skin, in the order they were added. footprint: mm a texel spans
    /// there; thinner strokes get fainter instead of breaking up.
    void paint(const Vec3& p, const Vec3& normal, float footprint, Vec3& albedo) const;

private:
    static constexpr float kCell = 3;  // mm
    static std::uint64_t key(int x, int y, int z);
    std::vector<Stroke> strokes_;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

}  // namespace mien::samples
