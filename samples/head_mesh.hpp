#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "samples/actor.hpp"
#include "samples/head_surface.hpp"

namespace mien::samples {

/// Concentric loops of vertices around an opening, from the skin inwards; all loops of an opening are equally
/// long. Index 0 lies at the actor's left end (x greatest for the mouth, the outer corner for an eye, the
/// back for an ear), a quarter of the way on at the top.
struct Loops {
    std::vector<std::vector<std::uint32_t>> rings;  ///< ring 0: on the skin grid
    int size() const { return rings.empty() ? 0 : static_cast<int>(rings[0].size()); }
};

struct VertexRange {
    std::uint32_t first = 0, count = 0;
    bool contains(std::uint32_t v) const { return v - first < count; }
};

/// The neutral head and what the muscles need to know of it.
struct HeadMesh {
    Mesh mesh;
    Landmarks landmarks;
    Loops mouth;    ///< to the border of the lips, over the lips, into the bag behind them
    Loops lids[2];  ///< [0] right, [1] left; to the margin and under it
    Loops nostrils[2], ears[2];
    struct Lash {
        std::uint32_t vertex;
        int column;  ///< of the margin: 0 .. half a loop, from the outer corner
        bool upper;
    };
    std::vector<Lash> lashes[2];
    VertexRange eyeballs[2], upper_teeth, lower_teeth, tongue;

    static constexpr int kLipBorder = 6;    ///< mouth ring on the vermilion border
    static constexpr int kLipContact = 11;  ///< mouth ring where the lips meet
    static constexpr int kInnerLip = 13;    ///< last mouth ring that is skin; the bag follows
    static constexpr int kLidMargin = 8;    ///< lid ring on the margin's outer edge
};

HeadMesh make_head_mesh(const HeadSurface& surface);

/// Half of a dental arch seen from below, (x, z) mm: a superellipse, blunter in front than an ellipse.
struct DentalArch {
    double rx, rz, centre;
    static constexpr double kPower = 2.2;
    /// angle: 0 on the midline .. pi / 2 behind the molars.
    Vec2d at(double angle) const {
        return {rx * std::pow(std::sin(angle), 2 / kPower), centre + rz * std::pow(std::max(std::cos(angle), 0.0), 2 / kPower)};
    }
    Vec2d normal(double angle) const {
        const Vec2d p = at(angle);
        return Vec2d(std::pow(p.x() / rx, kPower - 1) / rx, std::pow((p.y() - centre) / rz, kPower - 1) / rz).normalized();
    }
    /// z of the arch grown by `by` mm all round, at x.
    double z(double x, double by) const {
        return centre + (rz + by) * std::pow(std::max(1 - std::pow(std::abs(x) / (rx + by), kPower), 0.0), 1 / kPower);
    }
};
inline constexpr DentalArch kUpperArch{28.5, 40.5, 54.5}, kLowerArch{26.7, 38.6, 54.5};
inline constexpr double kUpperEdge = -72.4, kLowerEdge = -71.6;  ///< y of the biting edges, the mouth shut

/// Collects vertices, texture coordinates and quads of the parts of a head.
class HeadMeshBuilder {
public:
    using Corner = std::pair<std::uint32_t, std::uint32_t>;  ///< vertex, texture coordinate

    std::uint32_t vertex(const Vec3d& position);
    std::uint32_t texcoord(const Vec2d& uv);
    Corner corner(const Vec3d& position, const Vec2d& uv) { return {vertex(position), texcoord(uv)}; }
    void triangle(Surface surface, Corner a, Corner b, Corner c);
    /// Counter-clockwise a b c d, cut so that the cut is its own mirror image in x = 0.
    void quad(Surface surface, Corner a, Corner b, Corner c, Corner d);
    const Vec3d& position(std::uint32_t v) const { return positions_[v]; }
    const Vec2d& uv(std::uint32_t t) const { return texcoords_[t]; }
    std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(positions_.size()); }
    /// Starts a part; its triangles are those added until the next.
    void part(std::string name) { parts_.push_back({std::move(name), {}}); }
    Mesh build() const;

private:
    struct Corners {
        Surface surface;
        std::array<Corner, 3> corners;
    };
    std::vector<Vec3d> positions_;
    std::vector<Vec2d> texcoords_;
    std::vector<std::pair<std::string, std::vector<Corners>>> parts_;
};

/// Skin with its openings, and the bag of the mouth.
void add_skin(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head);
/// Eyeballs, teeth with gums, tongue.
void add_eyeballs(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head);
void add_teeth(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head);
/// Cards along the lid margins; after add_skin.
void add_lashes(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head);
/// Ring `ring` of the ear at loop angle `psi` (0 front, pi/2 top), on the left.
Vec3d ear_point(const HeadSurface& surface, int ring, double psi);
/// The loop angle at which a place of the left side of the head is seen from the middle of the ear.
double ear_angle(const Vec3d& p);
inline constexpr int kEarRings = 16;
/// How far hair lifts the scalp at a place of the skin, mm; 0 outside the hairline. x of either sign: it is combed from a
/// parting on the actor's left.
double hair_lift(const Vec3d& p);

}  // namespace mien::samples
