#include "samples/skin_paint.hpp"

#include <algorithm>
#include <cmath>

namespace mien::samples {

Vec3 skin_albedo(float melanin, float haemoglobin) {
    // Fitted so that (1, 1) is a fair face, sRGB (211, 163, 146); melanin eats blue most, haemoglobin green.
    const Vec3 dermis(0.86f, 0.79f, 0.74f), melanin_absorption(0.15f, 0.29f, 0.50f);
    const Vec3 blood(kBloodAbsorption[0], kBloodAbsorption[1], kBloodAbsorption[2]);
    return dermis.cwiseProduct((-melanin * melanin_absorption - haemoglobin * blood).array().exp().matrix());
}

Painter::Painter(const Mesh& neutral, const Landmarks& landmarks, const Complexion& complexion,
                 std::uint64_t seed)
    : places_(landmarks), complexion_(complexion), seed_(std::uint32_t(Random(seed).bits() & 0xffffff)) {
    const std::vector<Surface> surfaces = neutral.triangle_surfaces();
    bool has_teeth = false;
    for (std::size_t t = 0; t < neutral.triangles.size(); ++t)
        if (surfaces[t] == Surface::teeth)
            for (const std::uint32_t v : neutral.triangles[t]) {
                const float y = neutral.positions(v, 1);
                teeth_low_ = has_teeth ? std::min(teeth_low_, y) : y;
                teeth_high_ = has_teeth ? std::max(teeth_high_, y) : y;
                has_teeth = true;
            }
    teeth_middle_ = (teeth_low_ + teeth_high_) / 2;

    const auto bit = [](Surface s) { return 1u << int(s); };
    const SurfaceSampler face(neutral, bit(Surface::skin));
    const SurfaceSampler head(neutral, bit(Surface::skin) | bit(Surface::hair));
    // Each kind has its own numbers, so that more freckles do not move the brows.
    const auto random = [&](std::uint64_t kind) { return Random(seed * 1000003 + kind); };
    Random freckles = random(1), stubble = random(2), scalp = random(3), brows = random(4),
           lashes = random(5);
    if (face.area() > 0) {
        scatter_freckles(face, freckles);
        grow_stubble(face, stubble);
        grow_brows(face, brows);
    }
    if (head.area() > 0) grow_scalp(head, scalp);
    grow_lashes(lashes);
    folds_ = fold_lines(places_, seed_);
}

Pigment Painter::paint(Surface surface, const Vec3& p, const Vec3& normal, float footprint,
                       float open) const {
    switch (surface) {
        case Surface::eye:
        case Surface::cornea:
            return eyeball(p, footprint);
        case Surface::teeth:
            return tooth(p);
        case Surface::mouth:
            return mouth(p, normal);
        case Surface::lashes:
            return {complexion_.hair * 0.5f};
        case Surface::hair: {
            if (hair_cover(p, normal) < 1) break;   // skin still shows between the first hairs
            Vec3 albedo = hair(p, normal);
            hairs_.paint(p, normal, footprint, albedo);
            return {albedo};
        }
        case Surface::other: {
            const int side = Places::side_of(p);
            if (places_.from(p, places_.marks().eye_centre[side]) < 24) return eyeball(p, footprint);
            break;
        }
        case Surface::skin:
            break;
    }
    return skin(p, normal, footprint, open);
}

Pigment Painter::skin(const Vec3& p, const Vec3& normal, float footprint, float open) const {
    const Landmarks& marks = places_.marks();
    const float s = places_.scale();
    const int side = Places::side_of(p);
    const Vec3 q = p / s;
    const auto noise = [&](float size, int octaves, std::uint32_t kind) {
        return fractal_noise(q / size, octaves, seed_ + kind * 977u);
    };
    const auto near = [&](const Vec3& landmark, float radius) {
        return bump(places_.from(p, landmark), radius);
    };

    // Large regions: blood in cheeks, nose, ears and chin; a paler, yellower forehead and neck.
    const float blotch = noise(7, 3, 1), cloud = noise(26, 2, 2);
    const float cheek = near(marks.cheek[side], 21);
    float blood = 0.72f + 0.20f * cloud;
    float melanin = 1.10f + 0.16f * noise(31, 2, 3);
    blood += 0.50f * cheek * (0.9f + 0.45f * blotch);
    blood += 0.50f * near(marks.nose_tip, 12) + 0.34f * near(marks.nostril[side], 9);
    blood += 0.55f * near(marks.ear[side], 30) * (0.8f + 0.5f * blotch);
    blood += 0.22f * near(marks.chin, 14) + 0.12f * near(marks.glabella, 12);
    const float above_brows = (p.y() - marks.glabella.y()) / s;
    blood -= 0.16f * smooth_step(6, 34, above_brows);
    melanin += 0.10f * smooth_step(4, 30, above_brows);
    const float below_chin = (marks.chin.y() - p.y()) / s;
    blood -= 0.16f * smooth_step(-4, 24, below_chin);
    melanin += 0.07f * smooth_step(0, 30, below_chin);

    // Around the eyes: thin reddish lids, and the bluish shade below them.
    const float upper = places_.from_upper_lid(p, side), lower = places_.from_lower_lid(p, side);
    blood += 0.08f * smooth_step(11, 2, upper) + 0.12f * smooth_step(5, 0.5f, lower);
    melanin += 0.07f * smooth_step(12, 3, upper);
    const float inner = places_.from(p, places_.inner_corner(side));
    const float trough = p.y() < places_.inner_corner(side).y() + s
                             ? bump(lower - 6.5f, 4.5f) * (0.45f + 0.55f * smooth_step(26, 6, inner))
                             : 0.0f;
    melanin += 0.10f * trough;

    // Around the mouth.
    melanin += 0.06f * bump(places_.from(p, places_.mouth_centre()), 27);

    // Mottling: blood gathers in spots of every size.
    blood += 0.17f * blotch + 0.20f * noise(2.6f, 2, 4);
    melanin += 0.12f * noise(4.1f, 3, 5);

    // Vermilion: no melanin to speak of, blood close to the surface, fine vertical lines, dark where the lips
    // meet.
    const float ragged = 0.45f * noise(2.2f, 2, 6) + 0.5f * noise(9, 1, 7);
    // The colour fades before the corners, where the border runs into the cheek.
    const float sideways = std::abs(p.x() - places_.mouth_centre().x()) / (0.5f * places_.mouth_width());
    const float inside_border = places_.into_lips(p);
    const float fade =
        std::min(3.2f * smooth_step(0.50f, 1.02f, sideways), 0.8f * std::max(0.0f, inside_border));
    const float into_lips = inside_border + ragged - fade, behind = places_.behind_lips(p);
    const float off_mouth = places_.from(p, places_.mouth_centre()) / (places_.mouth_width() / s);
    float lip = smooth_step(-1.3f, 1.5f, into_lips);
    const bool faces_inward = normal.z() < 0.3f && off_mouth < 0.62f && behind > 0.5f &&
                              std::abs(p.x() - places_.mouth_centre().x()) < 0.52f * places_.mouth_width();
    const float inner_mouth = std::max(lip, faces_inward ? 1.0f : 0.0f) * smooth_step(0.8f, 4.5f, behind);
    lip = std::max(lip, inner_mouth);
    float lip_shade = 1;
    if (lip > 0) {
        const bool below = places_.below_lip_line(p);
        const Vec3 along(q.x() / 0.85f + 0.35f * noise(3, 1, 8), q.y() / 7.5f, below ? 5.0f : 0.0f);
        const float lines =
            gradient_noise(along, seed_ + 31) + 0.5f * gradient_noise(along * 2.1f, seed_ + 32);
        const float across = places_.across_lip(p);
        blood += lip * ((below ? 0.95f : 1.15f) - 0.25f * (across - 0.5f) + 0.25f * noise(3.5f, 2, 9));
        melanin += lip * (0.12f - 0.10f * across);
        lip_shade = 1 - lip * (0.05f + 0.13f * std::max(0.0f, lines) + 0.05f * std::abs(lines));
        lip_shade *= 1 - 0.30f * lip * bump(across, 0.16f);
        blood += 0.7f * inner_mouth;
        lip_shade *= 1 - 0.82f * inner_mouth * smooth_step(1, 16, behind);
    }
    const float roll = bump(into_lips + 1.6f, 1.0f) * (1 - lip);  // the pale rim round the vermilion

    Vec3 albedo = skin_albedo(complexion_.melanin * std::max(0.3f, melanin),
                              complexion_.haemoglobin * std::max(0.1f, blood));
    albedo *= lip_shade * (1 + 0.05f * roll * smooth_step(0.5f, 0.35f, off_mouth));
    albedo = albedo.cwiseProduct(blend(Vec3::Ones(), Vec3(0.89f, 0.93f, 0.99f), 0.6f * trough));

    // Where a line stays on a face at rest, skin is hollow and redder.
    float hollow = 0;
    const float folding = crease(p, hollow);
    albedo = albedo.cwiseProduct(blend(Vec3::Ones(), Vec3(0.30f, 0.0f, 0.0f), hollow * (1 - lip)));

    // Shaved skin is a little blue-grey.
    const float beard = complexion_.beard_shadow *
                        smooth_step(-34, -44, (p.y() - marks.glabella.y()) / s * 0.75f + 4) *
                        smooth_step(56, 30, places_.from(p, marks.chin)) * (1 - lip);
    albedo = albedo.cwiseProduct(
        blend(Vec3::Ones(), Vec3(0.82f, 0.88f, 0.95f), std::min(1.0f, beard * (1 + 0.4f * blotch))));

    spots_.paint(p, normal, footprint, albedo);

    // Pores and the fine relief of skin, as far as the texture can hold them.
    const float pore_size = 1.15f, fine = smooth_step(1.1f, 0.35f, footprint / s);
    if (fine > 0) {
        const Cellular pores = cellular_noise(q / pore_size, seed_ + 41);
        const float oily = 0.35f + 0.75f * near(marks.nose_tip, 16) + 0.55f * cheek;
        const float pit = smooth_step(0.38f, 0.08f, pores.nearest) * (1 - lip);
        const float plate = float(pores.id >> 24) / 255 - 0.5f;
        albedo *= 1 - fine * 0.14f * oily * pit;
        albedo *= 1 + fine * (0.05f * plate + 0.09f * noise(1.1f, 2, 10));
    }

    // Nostrils, the wet rim of the lids, the lash line.
    const float off_nostril = places_.from(p, marks.nostril[side]);
    const float nostril = std::max(smooth_step(0.80f, 0.42f, open) * smooth_step(17, 11, off_nostril),
                                   smooth_step(0.93f, 0.70f, open) * smooth_step(7, 4.5f, off_nostril));
    albedo = blend(albedo, Vec3(0.050f, 0.015f, 0.011f), 0.92f * nostril);
    const float into_eye = places_.into_eye(p, side);
    albedo = blend(albedo, Vec3(0.56f, 0.27f, 0.22f), 0.75f * smooth_step(-0.6f, 0.8f, into_eye));
    const float corner = bump(inner, 2.6f);
    albedo = blend(albedo, Vec3(0.60f, 0.25f, 0.21f), 0.4f * corner);
    const float lashes =
        std::max(0.62f * bump(upper, 0.85f), 0.30f * bump(lower, 0.8f)) * (1 - 0.8f * corner);
    albedo = blend(albedo, complexion_.hair * 0.8f, lashes * (0.85f + 0.3f * noise(0.8f, 1, 11)));

    // The fold that the upper lid opens under.
    const float fold = p.y() > marks.eye_centre[side].y() ? bump(upper - 4.3f, 0.8f) * smooth_step(3, 8, inner) : 0;
    albedo = albedo.cwiseProduct(blend(Vec3::Ones(), Vec3(0.66f, 0.55f, 0.52f), 0.6f * fold));

    // The soft shade under brows and hair, then the hairs.
    float along = 0;
    const float off_brow = line_distance(marks.brow[side], p, &along) / s;
    const float shade =
        0.30f * bump(off_brow, 3.2f) * smooth_step(-0.02f, 0.12f, along) * smooth_step(1.02f, 0.7f, along);
    albedo = blend(albedo, complexion_.hair * 1.2f, shade);
    const float scalp = hair_cover(p, normal);
    if (scalp > 0) albedo = blend(albedo, hair(p, normal), 0.95f * scalp);
    hairs_.paint(p, normal, footprint, albedo);

    Pigment pigment;
    pigment.albedo = albedo;
    const float covered = std::max({scalp, 0.6f * shade, nostril, lashes, inner_mouth});
    // Lids unroll rather than stretch: no blood to see there.
    const float lid = smooth_step(13, 5, std::min(upper, lower));
    pigment.perfusion = (1 - covered) * (1 - 0.85f * lid) * (1 + 0.35f * cheek + 0.25f * lip);
    pigment.crease = (1 - covered) * (1 - 0.7f * lip) * folding;
    return pigment;
}

void Painter::scatter_freckles(const SurfaceSampler& face, Random& random) {
    const Landmarks& marks = places_.marks();
    const float s = places_.scale();
    Random moles(random.bits());  // of their own, so that more freckles do not move them
    const Vec3 bridge = (marks.glabella + 2 * marks.nose_tip) / 3;
    // Poisson spots: as many candidates as the area asks for, kept where the sun and the genes put them.
    const int candidates = int(face.area() / (s * s) * 0.16f * std::min(3.0f, complexion_.freckles));
    for (int i = 0; i < candidates; ++i) {
        const SurfaceSampler::Place place = face.draw(random);
        const float keep = random.uniform(), size = random.uniform(), dark = random.uniform();
        const Vec3& p = place.position;
        const float cheek = bump(places_.from(p, marks.cheek[Places::side_of(p)]), 23);
        const float nose = bump(places_.from(p, bridge), 19);
        const float forehead = 0.10f * bump(places_.from(p, marks.glabella + s * Vec3(0, 28, -4)), 30);
        const float density = std::max({0.9f * cheek, nose, forehead}) + 0.012f;
        const float cluster = 0.6f + 0.9f * fractal_noise(p / (11 * s), 2, seed_ + 61);
        if (keep > density * cluster || places_.into_lips(p) > -2.5f || place.normal.z() < -0.2f) continue;
        if (places_.into_eye(p, Places::side_of(p)) > -2 || places_.into_scalp(p) > -6) continue;
        Stroke spot;
        spot.a = spot.b = p;
        spot.c = p + s * Vec3(random.normal(), random.normal(), 0) * 0.22f;
        spot.normal = place.normal;
        spot.radius_root = spot.radius_tip = s * (0.10f + 0.42f * size * size * size);
        spot.softness = s * (0.45f + 0.45f * size);
        spot.mode = Stroke::Mode::absorb;
        spot.tint = Vec3(0.78f, 0.62f, 0.46f);
        spot.opacity = (0.17f + 0.50f * dark * dark) * std::min(1.0f, complexion_.freckles);
        spots_.add(spot);
    }
    // A few moles, anywhere but on lips and lids.
    for (int i = 0, kept = 0; i < 400 && kept < 4; ++i) {
        const SurfaceSampler::Place place = face.draw(moles);
        const float size = moles.uniform();
        const Vec3& p = place.position;
        if (p.z() < marks.ear[0].z() || places_.into_scalp(p) > -6 || places_.into_lips(p) > -5) continue;
        if (places_.from(p, marks.eye_centre[Places::side_of(p)]) < 32 ||
            places_.from(p, marks.nose_tip) < 16)
            continue;
        Stroke mole{p, p, p, place.normal, s * (0.35f + 0.5f * size), s * (0.35f + 0.5f * size)};
        mole.softness = 0.35f * s;
        mole.mode = Stroke::Mode::absorb;
        mole.tint = Vec3(0.50f, 0.32f, 0.24f);
        mole.opacity = 0.75f;
        spots_.add(mole);
        ++kept;
    }
}

}  // namespace mien::samples
