#include <algorithm>
#include <cmath>

#include "samples/skin_paint.hpp"

namespace mien::samples {

std::vector<Fold> fold_lines(const Places& places, std::uint32_t seed) {
    std::vector<Fold> folds;
    const auto add_fold = [&](Landmarks::Line line, float width, float depth, float rest = 0) {
        Fold fold{std::move(line), width, depth, Vec2::Constant(1e9f), Vec2::Constant(-1e9f), rest};
        for (Vec3& p : fold.line) {
            p.z() = 0;
            fold.low = fold.low.cwiseMin(p.head<2>() - Vec2::Constant(3 * width));
            fold.high = fold.high.cwiseMax(p.head<2>() + Vec2::Constant(3 * width));
        }
        folds.push_back(std::move(fold));
    };
    const Landmarks& marks = places.marks();
    const float s = places.scale();
    Random random(seed + 7);
    const auto line = [](int points, auto&& at) {
        Landmarks::Line result;
        for (int i = 0; i < points; ++i) result.push_back(at(float(i) / float(points - 1)));
        return result;
    };
    // Across the forehead, following the brows.
    for (int row = 0; row < 4; ++row) {
        const float height = (15 + 10.5f * float(row)) * s, half = (46 - 3.5f * float(row)) * s,
                    phase = random.uniform(0, 6);
        add_fold(
            line(25,
                 [&](float t) -> Vec3 {
                     const float x = (2 * t - 1) * half, u = 2 * t - 1;
                     const float arch =
                         5 * s * std::sin(3.14159265f * std::min(1.0f, std::abs(u) * 1.1f)) - 4 * s * u * u;
                     return {x, marks.glabella.y() + height + arch + 0.9f * s * std::sin(5 * u + phase), 0};
                 }),
            0.75f * s, 0.75f);
    }
    // Between the brows.
    for (const float way : {-1.0f, 1.0f})
        add_fold(line(8,
                      [&](float t) -> Vec3 {
                          return marks.glabella + s * Vec3(way * (5.2f + 2.2f * t), -7 + 19 * t, 0);
                      }),
                 0.8f * s, 0.85f);
    for (int side = 0; side < 2; ++side) {
        const float out = side == 1 ? 1.0f : -1.0f;
        // Crow's feet.
        const Vec3 corner = places.outer_corner(side);
        for (const float tilt : {0.55f, 0.16f, -0.22f, -0.55f})
            add_fold(line(8,
                          [&](float t) -> Vec3 {
                              const float r = (6 + 15 * t) * s;
                              return corner +
                                     Vec3(out * r * std::cos(tilt), r * std::sin(tilt) - 0.06f * r * t, 0);
                          }),
                     0.55f * s, 0.75f);
        // Under the eye.
        for (const float drop : {4.0f, 7.5f})
            add_fold(line(10,
                          [&](float t) -> Vec3 {
                              const Vec3 lid = line_point(marks.lower_lid[side], 0.12f + 0.8f * t);
                              return lid - Vec3(0, s * (drop + 1.5f * std::sin(3.14159f * t)), 0);
                          }),
                     0.6f * s, 0.5f);
        // From the wing of the nose to the corner of the mouth.
        const Vec3 wing = marks.nostril[side] + s * Vec3(out * 11, 5, 0);
        const Vec3 mouth = (side == 1 ? marks.upper_lip_line.back() : marks.upper_lip_line.front()) +
                           s * Vec3(out * 9.5f, -3, 0);
        add_fold(line(12,
                      [&](float t) -> Vec3 {
                          return wing + t * (mouth - wing) +
                                 Vec3(out * s * 2.6f * std::sin(3.14159f * t), 0, 0);
                      }),
                 1.2f * s, 0.7f, 0.16f);
        // Across the side of the nose's bridge.
        for (int i = 0; i < 3; ++i)
            add_fold(line(5,
                          [&](float t) -> Vec3 {
                              return marks.glabella +
                                     s * Vec3(out * (4 + 7 * t), -14 - 5 * float(i) - 3.5f * t, 0);
                          }),
                     0.55f * s, 0.55f);
    }
    // Round the lips, where they purse.
    for (int i = 0; i < 26; ++i) {
        const bool upper = i < 13;
        const float t = 0.10f + 0.80f * (float(i % 13) + random.uniform(0.2f, 0.8f)) / 13;
        const Vec3 start = line_point(upper ? marks.upper_lip_outline : marks.lower_lip_outline, t);
        const Vec3 way = (start - places.mouth_centre() + Vec3(0, upper ? 9 * s : -9 * s, 0)).normalized();
        const float reach = random.uniform(3.5f, 7) * s;
        add_fold(line(4, [&](float u) -> Vec3 { return start + way * (0.8f * s + u * reach); }), 0.4f * s,
                 0.4f);
    }
    return folds;
}

float Painter::crease(const Vec3& p, float& rest) const {
    rest = 0;
    if (p.z() < places_.marks().ear[0].z()) return 0;
    const Vec3 flat(p.x(), p.y(), 0);
    const float wobble = 0.5f * places_.scale() * fractal_noise(p / (6 * places_.scale()), 2, seed_ + 51);
    float deepest = 0;
    for (const Fold& fold : folds_) {
        if ((flat.head<2>().array() < fold.low.array()).any() ||
            (flat.head<2>().array() > fold.high.array()).any())
            continue;
        float along = 0;
        const float distance = line_distance(fold.line, flat + Vec3(0, wobble, 0), &along) / fold.width;
        const float ends = smooth_step(0, 0.18f, along) * smooth_step(1, 0.82f, along);
        deepest = std::max(deepest, fold.depth * ends * std::exp(-distance * distance));
        rest = std::max(rest, fold.rest * ends * bump(distance, 1.9f));
    }
    return deepest;
}

}  // namespace mien::samples
