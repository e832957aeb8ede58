#include <algorithm>
#include <cmath>

#include "samples/skin_paint.hpp"

namespace mien::samples {
namespace {

Vec3 tangent_part(const Vec3& v, const Vec3& normal) {
    const Vec3 flat = v - v.dot(normal) * normal;
    const float length = flat.norm();
    return length > 1e-6f ? Vec3(flat / length) : normal.unitOrthogonal();
}

}  // namespace

Vec3 Painter::hair_flow(const Vec3& p, const Vec3& normal) const {
    const float s = places_.scale();
    // Hair grows away from the whorl at the back of the crown, and hangs.
    const Vec3 away = (p - places_.hair_whorl()).normalized();
    const float swing = 0.5f * fractal_noise(p / (24 * s), 2, seed_ + 99);
    // On top in front it is combed back and away from a parting on the actor's left.
    const Vec3 q = (p - places_.marks().glabella) / s;
    const float combed = smooth_step(-75, -35, q.z()) * smooth_step(28, 52, q.y());
    // Over the forehead it rises before it bends.
    const float rising = 0.85f * smooth_step(18, 4, places_.into_scalp(p));
    const Vec3 comb = blend(Vec3(q.x() > 30 ? 0.8f : -0.85f, 0.35f, -0.55f), Vec3(q.x() > 30 ? 0.3f : -0.3f, 0.95f, -0.35f), rising);
    const Vec3 flow = tangent_part(away + Vec3(0, -0.45f, 0.1f) + combed * (1.6f * comb - away), normal);
    return (flow + swing * normal.cross(flow)).normalized();
}

float Painter::into_hair(const Vec3& p) const {
    return places_.into_scalp(p) + 4.5f * fractal_noise(p / (17 * places_.scale()), 2, seed_ + 98);
}

float Painter::hair_cover(const Vec3& p, const Vec3& normal) const {
    const float s = places_.scale(), inside = into_hair(p);
    if (inside < -6) return 0;
    if (inside > 19) return 1;
    // Hairs gather in strands, and between them skin shows for longer.
    const Vec3 flow = hair_flow(p, normal), across = normal.cross(flow);
    const Vec3 strand = Vec3(p.dot(across) / 0.7f, p.dot(flow) / 8, p.dot(normal) / 4) / s;
    return smooth_step(-1, 14, inside + 6.5f * fractal_noise(strand, 2, seed_ + 97));
}

void Painter::grow_scalp(const SurfaceSampler& head, Random& random) {
    const float s = places_.scale();
    const int candidates = int(std::min(head.area() / (s * s) * 0.75f, 160000.0f));
    for (int i = 0; i < candidates; ++i) {
        const SurfaceSampler::Place place = head.draw(random);
        const float keep = random.uniform(), shade = random.normal(), turn = random.normal(),
                    curl = random.normal(), length = random.uniform(), fine = random.uniform();
        const float inside = into_hair(place.position), grown = smooth_step(-4, 14, inside);
        if (keep > grown) continue;   // thinning out towards the hairline, and finer there
        const Vec3 flow = hair_flow(place.position, place.normal), across = place.normal.cross(flow);
        const Vec3 start = (flow + 0.22f * turn * across).normalized();
        const Vec3 end = (start + 0.25f * curl * across).normalized();
        const float reach = s * (place.surface == Surface::hair ? 7 + 10 * length : 3 + 5 * length) * (0.45f + 0.55f * grown);
        Stroke hair;
        hair.a = place.position;
        hair.b = hair.a + 0.5f * reach * start;
        hair.c = hair.b + 0.5f * reach * end;
        hair.normal = place.normal;
        hair.radius_root = s * (0.06f + 0.04f * grown + 0.10f * fine * grown);
        hair.radius_tip = 0.03f * s;
        hair.softness = 0.08f * s;
        hair.tint = complexion_.hair * 0.85f * std::exp(0.38f * shade);
        hair.opacity = 0.45f + 0.30f * grown;
        hairs_.add(hair);
    }
}

void Painter::grow_brows(const SurfaceSampler& face, Random& random) {
    const float s = places_.scale();
    for (int side = 0; side < 2; ++side) {
        const Landmarks::Line& brow = places_.marks().brow[side];
        float length = 0;
        for (std::size_t i = 1; i < brow.size(); ++i) length += (brow[i] - brow[i - 1]).norm();
        length = std::max(length, 1e-3f);
        // Roots lie on the skin itself: candidates over the whole face, kept where the brow is.
        const int wanted = int(760 * length / (50 * s));
        Vec3 low = brow.front(), high = low;
        for (const Vec3& p : brow) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        const Vec3 reach_out = Vec3::Constant(7 * s);
        low -= reach_out;
        high += reach_out;
        int grown = 0;
        for (int tries = 0; tries < 1500000 && grown < wanted; ++tries) {
            const SurfaceSampler::Place place = face.draw(random);
            const Vec3& p = place.position;
            if ((p.array() < low.array()).any() || (p.array() > high.array()).any()) continue;
            float along = 0;
            const float off = line_distance(brow, p, &along) / s;
            if (off > 6 || place.normal.z() < 0.1f) continue;
            // Broad and soft at the inner end, thickest at a third, tapering to the tail.
            const float half_width =
                3.7f * smooth_step(-0.10f, 0.16f, along) * (1 - 0.80f * smooth_step(0.35f, 1.0f, along)) +
                0.4f;
            if (random.uniform() >
                bump(off, half_width * 0.85f) * (0.45f + 0.55f * smooth_step(0, 0.15f, along)))
                continue;

            const Vec3 here = line_point(brow, along);
            const Vec3 outward = (line_point(brow, std::min(1.0f, along + 0.06f)) -
                                  line_point(brow, std::max(0.0f, along - 0.06f)))
                                     .normalized();
            const Vec3 up =
                tangent_part(place.normal.cross(outward) * (side == 1 ? 1.0f : -1.0f), place.normal);
            const float height = (p - here).dot(up) / (s * half_width);  // -1 lower edge .. 1 upper edge
            // At the inner end hairs stand up; along the body the lower ones sweep up and the upper ones down
            // to meet.
            const float stand = 0.95f * (1 - smooth_step(0.0f, 0.26f, along)) + 0.34f - 0.42f * height -
                                0.30f * smooth_step(0.5f, 1.0f, along);
            const float angle = stand + 0.16f * random.normal();
            const Vec3 start = tangent_part(std::cos(angle) * outward + std::sin(angle) * up, place.normal);
            const float bend = angle * 0.55f - 0.10f;
            const Vec3 end = tangent_part(std::cos(bend) * outward + std::sin(bend) * up, place.normal);
            const float reach = s * (6.6f - 2.2f * along) * random.uniform(0.65f, 1.1f);
            Stroke hair;
            hair.a = p;
            hair.b = p + 0.5f * reach * start;
            hair.c = hair.b + 0.5f * reach * end;
            hair.normal = place.normal;
            hair.radius_root = s * random.uniform(0.08f, 0.14f);
            hair.radius_tip = 0.02f * s;
            hair.softness = 0.07f * s;
            hair.tint = complexion_.hair * 0.75f * std::exp(0.32f * random.normal());
            hair.opacity = 0.60f * (0.35f + 0.65f * smooth_step(0.0f, 0.18f, along)) * (1 - 0.45f * smooth_step(0.8f, 1.0f, along));
            hairs_.add(hair);
            ++grown;
        }
    }
}

void Painter::grow_lashes(Random& random) {
    const float s = places_.scale();
    const Landmarks& marks = places_.marks();
    for (int side = 0; side < 2; ++side)
        for (const bool upper : {true, false}) {
            const Landmarks::Line& lid = upper ? marks.upper_lid[side] : marks.lower_lid[side];
            const int count = upper ? 70 : 42;
            for (int i = 0; i < count; ++i) {
                const float along = 0.10f + 0.88f * (float(i) + random.uniform()) / float(count);
                const Vec3 root = line_point(lid, along);
                const Vec3 normal = (root - marks.eye_centre[side]).normalized();
                const float fan =
                    (along - 0.45f) * 1.5f * (side == 1 ? 1.0f : -1.0f) + 0.15f * random.normal();
                const Vec3 way = tangent_part(Vec3(fan, upper ? 1.0f : -1.0f, 0), normal);
                const float reach = s * (upper ? 1.9f : 1.2f) * random.uniform(0.6f, 1.1f);
                Stroke lash{root,     root + 0.5f * reach * way, root + reach * way, normal, 0.10f * s,
                            0.02f * s};
                lash.tint = complexion_.hair * 0.5f;
                lash.opacity = upper ? 0.65f : 0.4f;
                lash.softness = 0.08f * s;
                hairs_.add(lash);
            }
        }
}

void Painter::grow_stubble(const SurfaceSampler& face, Random& random) {
    const Landmarks& marks = places_.marks();
    const float s = places_.scale();
    const int candidates = int(face.area() / (s * s) * 0.5f * complexion_.beard_shadow);
    for (int i = 0; i < candidates; ++i) {
        const SurfaceSampler::Place place = face.draw(random);
        const float keep = random.uniform();
        const Vec3& p = place.position;
        const float below_nose = (marks.nostril[0].y() - p.y()) / s;
        const float density = smooth_step(2, 9, below_nose) *
                              smooth_step(66, 34, places_.from(p, marks.chin)) *
                              smooth_step(-1, -4, places_.into_lips(p));
        if (keep > density || p.z() < marks.ear[0].z()) continue;
        const Vec3 way = tangent_part(Vec3(p.x() * 0.004f, -1, 0), place.normal);
        Stroke bristle{p, p + 0.25f * s * way, p + 0.5f * s * way, place.normal, 0.08f * s, 0.05f * s};
        bristle.tint = Vec3(0.60f, 0.60f, 0.63f);
        bristle.mode = Stroke::Mode::absorb;
        bristle.opacity = 0.5f;
        bristle.softness = 0.1f * s;
        spots_.add(bristle);
    }
}

}  // namespace mien::samples
