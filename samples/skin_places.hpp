#pragma once

#include "samples/actor.hpp"

namespace mien::samples {

/// Where on a neutral head a point is, told from its landmarks; lengths in mm scaled to the head (1 = a head
/// whose eyes are 62 mm apart).
class Places {
public:
    explicit Places(const Landmarks& landmarks);

    const Landmarks& marks() const { return marks_; }
    float scale() const { return scale_; }  ///< mm per scaled mm

    float from(const Vec3& p, const Vec3& landmark) const { return (p - landmark).norm() / scale_; }
    /// How far inside the vermilion border, seen from the front; negative outside.
    float into_lips(const Vec3& p) const;
    /// How far behind the line where the lips meet; negative in front of it. Meaningless away from the mouth.
    float behind_lips(const Vec3& p) const;
    /// 0 at the seam, 1 at the border: how far up or down a lip (only where into_lips > 0).
    float across_lip(const Vec3& p) const;
    bool below_lip_line(const Vec3& p) const;
    float from_upper_lid(const Vec3& p, int side) const;
    float from_lower_lid(const Vec3& p, int side) const;
    /// How far inside the opening between the lids, seen from the front; negative outside.
    float into_eye(const Vec3& p, int side) const;
    /// How far inside the hairline; negative on face, ears and neck.
    float into_scalp(const Vec3& p) const;
    /// 0 the actor's right, 1 left.
    static int side_of(const Vec3& p) { return p.x() > 0 ? 1 : 0; }
    float iris_radius() const { return iris_radius_; }  ///< mm

    Vec3 hair_whorl() const { return whorl_; }
    float mouth_width() const { return mouth_width_; }  ///< mm
    Vec3 mouth_centre() const { return mouth_; }
    Vec3 outer_corner(int side) const { return marks_.upper_lid[side].back(); }
    Vec3 inner_corner(int side) const { return marks_.upper_lid[side].front(); }

private:
    Landmarks marks_;
    float scale_, iris_radius_, mouth_width_;
    Vec3 mouth_, whorl_;
    Landmarks::Line lips_, eye_[2];  // closed outlines
};

/// How far inside the hairline a place of a head is, as Places::into_scalp: q and the ear of its side from the middle
/// between the ears, heights of glabella and chin over that middle; scaled mm.
float into_scalp(const Vec3& q, const Vec3& ear, float glabella, float chin);
/// Distance from p to a polyline; `along` gets where on it, 0 first point .. 1 last.
float line_distance(const Landmarks::Line& line, const Vec3& p, float* along = nullptr);
/// Point of a polyline at 0 .. 1 of its length.
Vec3 line_point(const Landmarks::Line& line, float along);

}  // namespace mien::samples
