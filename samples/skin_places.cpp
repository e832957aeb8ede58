#include "samples/skin_places.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace mien::samples {
namespace {

// Signed distance to a closed outline seen from the front, positive inside.
float inside_distance(const Landmarks::Line& outline, const Vec3& p) {
    float best = 1e9f;
    bool inside = false;
    for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
        const Vec2 a = outline[j].head<2>(), b = outline[i].head<2>(), q = p.head<2>();
        const Vec2 ab = b - a;
        const float t = std::clamp((q - a).dot(ab) / std::max(1e-9f, ab.squaredNorm()), 0.0f, 1.0f);
        best = std::min(best, (q - a - t * ab).norm());
        if ((a.y() > q.y()) != (b.y() > q.y()) && q.x() < a.x() + ab.x() * (q.y() - a.y()) / ab.y())
            inside = !inside;
    }
    return inside ? best : -best;
}

Landmarks::Line joined(const Landmarks::Line& there, const Landmarks::Line& back) {
    Landmarks::Line outline = there;
    outline.insert(outline.end(), back.rbegin(), back.rend());
    return outline;
}

// The polyline's point above or below p, seen from the front.
Vec3 at_x(const Landmarks::Line& line, float x) {
    if (x <= line.front().x()) return line.front();
    for (std::size_t i = 1; i < line.size(); ++i)
        if (x <= line[i].x()) {
            const float span = line[i].x() - line[i - 1].x();
            const float t = span > 1e-6f ? (x - line[i - 1].x()) / span : 0.0f;
            return line[i - 1] + t * (line[i] - line[i - 1]);
        }
    return line.back();
}

}  // namespace

float line_distance(const Landmarks::Line& line, const Vec3& p, float* along) {
    float best = 1e9f, where = 0, walked = 0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vec3 ab = line[i] - line[i - 1];
        const float length = ab.norm();
        const float t = std::clamp((p - line[i - 1]).dot(ab) / std::max(1e-9f, length * length), 0.0f, 1.0f);
        const float distance = (p - line[i - 1] - t * ab).norm();
        if (distance < best) {
            best = distance;
            where = walked + t * length;
        }
        walked += length;
    }
    if (along) *along = walked > 0 ? where / walked : 0;
    return best;
}

Vec3 line_point(const Landmarks::Line& line, float along) {
    float total = 0;
    for (std::size_t i = 1; i < line.size(); ++i) total += (line[i] - line[i - 1]).norm();
    float left = along * total;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const float length = (line[i] - line[i - 1]).norm();
        if (left <= length)
            return line[i - 1] + (length > 0 ? left / length : 0.0f) * (line[i] - line[i - 1]);
        left -= length;
    }
    return line.back();
}

Places::Places(const Landmarks& landmarks) : marks_(landmarks) {
    for (int side = 0; side < 2; ++side)
        assert(marks_.brow[side].size() > 1 && marks_.upper_lid[side].size() > 1 &&
               marks_.lower_lid[side].size() > 1);
    assert(marks_.upper_lip_outline.size() > 1 && marks_.lower_lip_outline.size() > 1);
    assert(marks_.upper_lip_line.size() > 1 && marks_.lower_lip_line.size() > 1);

    scale_ = (marks_.eye_centre[1] - marks_.eye_centre[0]).norm() / 62;
    const auto fissure = [&](int side) { return (outer_corner(side) - inner_corner(side)).norm(); };
    iris_radius_ = 0.225f * 0.5f * (fissure(0) + fissure(1));  // 5.9 mm in an opening of 26
    lips_ = joined(marks_.upper_lip_outline, marks_.lower_lip_outline);
    for (int side = 0; side < 2; ++side) eye_[side] = joined(marks_.upper_lid[side], marks_.lower_lid[side]);
    const Vec3 right = marks_.upper_lip_line.front(), left = marks_.upper_lip_line.back();
    mouth_width_ = (left - right).norm();
    mouth_ = line_point(marks_.upper_lip_line, 0.5f);
    const Vec3 ears = (marks_.ear[0] + marks_.ear[1]) / 2;
    whorl_ = ears + scale_ * Vec3(12, 125, -62);
}

float Places::into_lips(const Vec3& p) const {
    if ((p - mouth_).norm() > mouth_width_) return -mouth_width_ / scale_;
    return inside_distance(lips_, p) / scale_;
}

float Places::behind_lips(const Vec3& p) const {
    const float seam = (at_x(marks_.upper_lip_line, p.x()).z() + at_x(marks_.lower_lip_line, p.x()).z()) / 2;
    return (seam - p.z()) / scale_;
}

bool Places::below_lip_line(const Vec3& p) const {
    return p.y() < (at_x(marks_.upper_lip_line, p.x()).y() + at_x(marks_.lower_lip_line, p.x()).y()) / 2;
}

float Places::across_lip(const Vec3& p) const {
    const bool lower = below_lip_line(p);
    const float seam = at_x(lower ? marks_.lower_lip_line : marks_.upper_lip_line, p.x()).y();
    const float border = at_x(lower ? marks_.lower_lip_outline : marks_.upper_lip_outline, p.x()).y();
    return std::clamp((p.y() - seam) / (border - seam + (lower ? -1e-3f : 1e-3f)), 0.0f, 1.0f);
}

float Places::from_upper_lid(const Vec3& p, int side) const {
    return line_distance(marks_.upper_lid[side], p) / scale_;
}
float Places::from_lower_lid(const Vec3& p, int side) const {
    return line_distance(marks_.lower_lid[side], p) / scale_;
}

float Places::into_eye(const Vec3& p, int side) const {
    if ((p - marks_.eye_centre[side]).norm() > 40 * scale_) return -40;
    return inside_distance(eye_[side], p) / scale_;
}

float Places::into_scalp(const Vec3& p) const {
    const Vec3 ears = (marks_.ear[0] + marks_.ear[1]) / 2;
    return samples::into_scalp((p - ears) / scale_, (marks_.ear[side_of(p)] - ears) / scale_,
                               (marks_.glabella.y() - ears.y()) / scale_, (marks_.chin.y() - ears.y()) / scale_);
}

float into_scalp(const Vec3& q, const Vec3& ear, float glabella, float chin) {
    const float azimuth =
        std::atan2(std::abs(q.x()), q.z()) * 57.29578f;  // 0 in front, 90 at the ear, 180 behind
    const float top = glabella + 0.43f * (glabella - chin);  // the face's thirds are equal, nearly
    // Height of the hairline over the ears' centre, by azimuth: forehead, recess over the temple, temple, sideburn, behind the
    // ear, nape.
    const std::array<std::pair<float, float>, 13> hairline{{{0, top - 2},
                                                            {16, top - 1},
                                                            {28, top - 1},
                                                            {38, top - 8},
                                                            {46, top - 22},
                                                            {53, glabella + 10},
                                                            {62, glabella - 2},
                                                            {70, 6},
                                                            {77, -4},
                                                            {100, -14},
                                                            {112, -42},
                                                            {140, chin + 26},
                                                            {180, chin + 18}}};
    const auto height = [&](float at) {
        std::size_t i = 1;
        while (i + 1 < hairline.size() && hairline[i].first < at) ++i;
        const auto [a0, h0] = hairline[i - 1];
        const auto [a1, h1] = hairline[i];
        const float t = std::clamp((at - a0) / (a1 - a0), 0.0f, 1.0f);
        return h0 + (h1 - h0) * t * t * (3 - 2 * t);
    };
    // Where the line is steep, height over it is not distance from it.
    constexpr float kSpan = 9;  // degrees
    const float radius = std::max(45.0f, std::hypot(q.x(), q.z()));
    const float slope =
        (height(azimuth + kSpan) - height(azimuth - kSpan)) / (2 * kSpan * radius / 57.29578f);
    float inside = (q.y() - height(azimuth)) / std::sqrt(1 + slope * slope);
    // No hair on the ears.
    const Vec3 e = q - ear;
    const float inward = std::max(0.0f, std::abs(ear.x()) - std::abs(q.x()));
    const float off_ear = std::hypot(e.y() / 42, (e.z() + 0.15f * e.y()) / 26, inward / 14);
    inside = std::min(inside, 24 * (off_ear - 1));
    return inside;
}

}  // namespace mien::samples
