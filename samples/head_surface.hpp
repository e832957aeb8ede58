#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "samples/head_mathematics.hpp"

namespace mien::samples {

using Vec3d = Eigen::Vector3d;
using Vec2d = Eigen::Vector2d;

/// What makes one head differ from another, mm. The origin lies between the eyeball centres in height and
/// depth of the ear openings; +z out of the face.
struct HeadProportions {
    double width = 1, jaw = 1, nose = 1, nose_width = 1, lips = 1, mouth = 1, chin = 1, brow = 1,
           eye_opening = 1;
    double nose_tip = 0, nose_bridge = 0;  ///< how far the tip is turned up, how far the bridge is humped
    double nose_aside = 0, chin_aside = 0, mouth_tilt = 0,
           brow_tilt = 0;  ///< what makes left and right differ
    double eye_x = 31.5;   ///< half the distance of the pupils
    double eye_y = 0;
    double eye_z = 69.5;         ///< of the eyeball centre
    double eye_radius = 12.5;  ///< of the eyeball
};
HeadProportions head_proportions(std::uint64_t seed);

/// How far the nose stands off the face without one, mm, at the frontal place (x, y), x >= 0. It goes forward, somewhat down and
/// to the side, so that what looks down is no cliff.
Vec3d nose_offset(const HeadProportions& proportions, double x, double y);

/// The smooth skin without openings: a loft of tilted horizontal sections, with the face sculpted on its
/// front. Mirror symmetric; every function but skewed() takes the left half (x >= 0, 0 <= phi <= pi).
class HeadSurface {
public:
    static constexpr double kBottom = -190, kTop = 160;  ///< range of t

    explicit HeadSurface(const HeadProportions& proportions);

    /// The loft: phi = 0 front midline, pi back midline; t runs from the neck's end up to the crown, about
    /// equal to y on the front of the face.
    Vec3d loft(double phi, double t) const;
    /// The loft with the face on it.
    Vec3d skin(double phi, double t) const { return sculpt(loft(phi, t)); }
    /// The place of the loft's front that looks like (x, y) from the front: (phi, t).
    Vec2d from_front(double x, double y) const;
    /// The skin at frontal loft position (x, y).
    Vec3d front(double x, double y) const;

    /// The skin at the side that looks like (y, z) from the left.
    Vec3d side(double y, double z) const;

    /// A point of the symmetric head where this person's left and right differ; the eyes stay.
    Vec3d skewed(const Vec3d& p) const;

    /// Palpebral fissure: the lid margins in frontal view; q = 0 inner, 1 outer corner. (x, y)
    Vec2d lid_margin(bool upper, double q) const;
    /// Vermilion borders and the line where the lips meet, at x >= 0 from the front: y.
    double upper_border(double x) const;
    double lower_border(double x) const;
    double lip_line(double x) const;
    double mouth_half_width() const { return 25.5 * p_.mouth; }

    Vec3d eye_centre() const { return {p_.eye_x, p_.eye_y, p_.eye_z}; }
    const HeadProportions& proportions() const { return p_; }

private:
    Vec3d sculpt(const Vec3d& p) const;

    HeadProportions p_;
    Spline front_y_, front_z_, half_width_, side_y_, side_z_, back_y_, back_z_, front_square_;
};

}  // namespace mien::samples
