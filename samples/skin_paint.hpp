#pragma once

#include <cmath>

#include "samples/skin.hpp"
#include "samples/skin_places.hpp"
#include "samples/skin_strokes.hpp"

namespace mien::samples {

/// 1 in the middle, 1/e at `radius`.
inline float bump(float distance, float radius) {
    return std::exp(-(distance / radius) * (distance / radius));
}
inline Vec3 blend(const Vec3& a, const Vec3& b, float t) {
    return a + t * (b - a);
}

/// What the texture knows of one texel before any motion.
struct Pigment {
    Vec3 albedo;          ///< linear
    float perfusion = 0;  ///< how strongly blood shows when the skin is squeezed, 0 .. about 1.5
    float crease = 0;     ///< how deep a wrinkle lies here when the skin folds, 0 .. 1
};

/// A line the skin wrinkles along, seen from the front.
struct Fold {
    Landmarks::Line line;    ///< z = 0
    float width, depth;      ///< half width, mm; 0 .. 1
    Vec2 low, high;          ///< a box that its influence does not leave
    float rest = 0;          ///< how much of the light its hollow keeps off a face at rest, 0 .. 1
};
/// Forehead, between the brows, crow's feet, under the eyes, nasolabial, across the nose, round the lips.
std::vector<Fold> fold_lines(const Places& places, std::uint32_t seed);

/// Paints every kind of surface of a head, point by point in the space of its neutral mesh. Thread-safe once
/// made.
class Painter {
public:
    Painter(const Mesh& neutral, const Landmarks& landmarks, const Complexion& complexion,
            std::uint64_t seed);

    /// footprint: mm that a texel spans here; finer detail is left out.
    /// open: how much of the sky the point sees, 0 .. 1.
    Pigment paint(Surface surface, const Vec3& p, const Vec3& normal, float footprint, float open) const;

    const Places& places() const { return places_; }

private:
    Pigment skin(const Vec3& p, const Vec3& normal, float footprint, float open) const;
    Pigment eyeball(const Vec3& p, float footprint) const;
    Pigment tooth(const Vec3& p) const;
    Pigment mouth(const Vec3& p, const Vec3& normal) const;
    Vec3 hair(const Vec3& p, const Vec3& normal) const;   // without its single hairs
    float crease(const Vec3& p, float& rest) const;   // Pigment::crease and Fold::rest of the lines nearby
    Vec3 hair_flow(const Vec3& p, const Vec3& normal) const;
    float into_hair(const Vec3& p) const;                         // as Places::into_scalp, along this person's uneven hairline
    float hair_cover(const Vec3& p, const Vec3& normal) const;   // part of the skin that hair hides

    void grow_brows(const SurfaceSampler& face, Random& random);
    void grow_lashes(Random& random);
    void grow_scalp(const SurfaceSampler& head, Random& random);
    void grow_stubble(const SurfaceSampler& face, Random& random);
    void scatter_freckles(const SurfaceSampler& face, Random& random);

    Places places_;
    Complexion complexion_;
    std::uint32_t seed_;
    float teeth_low_ = 0, teeth_high_ = 0, teeth_middle_ = 0;  // heights of the arches and of the bite, mm
    StrokeField spots_, hairs_;                                // under and over the skin's own detail
    std::vector<Fold> folds_;
};

/// Light through melanin and blood (after the two-pigment models of skin, Jimenez et al. 2010): the albedo of
/// skin with so much melanin and haemoglobin, both 1 for the fair adult.
Vec3 skin_albedo(float melanin, float haemoglobin);
/// What one more unit of haemoglobin multiplies the albedo by, as a natural logarithm per channel.
inline constexpr float kBloodAbsorption[3] = {0.13f, 0.50f, 0.42f};

}  // namespace mien::samples
