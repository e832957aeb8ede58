#include "samples/skin_relief.hpp"

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "samples/skin_paint.hpp"

namespace mien::samples {
namespace {

constexpr float kDeepest = 0.5f;     // mm, of a fold of depth 1
constexpr float kPoreDepth = 0.045f; // mm
constexpr float kPoreSpacing = 1.25f;  // mm
constexpr float kSofter = 0.8f;      // how far a pore's rim follows the skin around it
constexpr float kFoldReach = 3.6f;   // half widths

/// What the folds of skin_folds.cpp leave out: across the chin, where the lower lip pushes.
void add_chin(const Places& places, std::vector<Fold>& folds) {
    const Landmarks& marks = places.marks();
    const float s = places.scale();
    const Vec3 lip = line_point(marks.lower_lip_outline, 0.5f);
    for (int i = 0; i < 2; ++i) {
        Fold fold{{}, 1.1f * s, 0.8f - 0.25f * float(i), {}, {}};
        const float y = lip.y() + (0.42f + 0.22f * float(i)) * (marks.chin.y() - lip.y());
        for (int k = 0; k <= 16; ++k) {
            const float u = float(k) / 8 - 1;
            fold.line.push_back({lip.x() + 15 * s * u, y - 3.5f * s * u * u, 0});
        }
        fold.low = Vec2(lip.x() - 20 * s, y - 8 * s);
        fold.high = Vec2(lip.x() + 20 * s, y + 5 * s);
        folds.push_back(std::move(fold));
    }
}

struct Offset {
    float across;   // mm, signed
    float along;    // 0 .. 1
    Vec2 direction; // unit, across the line
};

Offset offset_from(const Landmarks::Line& line, const Vec2& p) {
    float length = 0, best = 1e9f, walked = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) length += (line[i + 1] - line[i]).norm();
    Offset result{1e9f, 0, Vec2::UnitY()};
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Vec2 a = line[i].head<2>(), way = line[i + 1].head<2>() - a;
        const float step = way.norm();
        if (!(step > 0)) continue;
        const float t = std::clamp((p - a).dot(way) / (step * step), 0.0f, 1.0f);
        const float distance = (p - a - t * way).norm();
        if (distance < best) {
            best = distance;
            const Vec2 normal(-way.y() / step, way.x() / step);
            result = {(p - a).dot(normal) < 0 ? -distance : distance, (walked + t * step) / length, normal};
        }
        walked += step;
    }
    return result;
}

/// The nearest pore: one at a random place of every cell, as cellular_noise's sites, but with the way to it.
struct Pore {
    Vec3 way;
    float size;
};
Pore nearest_pore(const Vec3& p, std::uint32_t seed) {
    const Vec3 q = p / kPoreSpacing;
    const Eigen::Vector3i cell = q.array().floor().cast<int>();
    Pore nearest{Vec3::Constant(9), 0};
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
                const Eigen::Vector3i c = cell + Eigen::Vector3i(x, y, z);
                const std::uint32_t h = lattice_hash(c.x(), c.y(), c.z(), seed);
                const Vec3 site = c.cast<float>() + Vec3(float(h & 1023), float(h >> 10 & 1023), float(h >> 20 & 1023)) / 1024;
                const Vec3 way = kPoreSpacing * (q - site);
                if (way.squaredNorm() < nearest.way.squaredNorm()) nearest = {way, 0.4f + 0.6f * float(h >> 24 & 255) / 255};
            }
    return nearest;
}

}  // namespace

float fold_depth(float squeeze, float threshold) {
    const float beyond = squeeze - threshold;
    return beyond > 0 ? 1 - std::exp(-std::sqrt(beyond / 0.12f)) : 0.0f;
}

float fold_profile(float across, float width, float pressed) {
    const float x = std::abs(across) / (width * (1 - 0.5f * pressed));
    const float groove = std::exp(-std::pow(x, 2 - 0.8f * pressed));
    const float ridge = (x - 1.9f) / 0.8f;
    return -groove + 0.42f * std::exp(-ridge * ridge);
}

struct SkinRelief::Laid {
    struct Texel {
        std::uint32_t place;
        Triangle corners;
        float b1, b2;
        Vec3 pore;             // way from the nearest pore, mm, in the tangent plane
        float pore_depth, pore_radius;
    };
    struct FoldTexel {
        std::uint32_t texel;
        Vec3 direction;        // unit tangent across the fold
        float across, width, depth, threshold;
    };

    Laid(const Actor& actor, const TexelMap& texel_map, std::uint64_t seed)
        : stretch(actor.neutral()), width(texel_map.width), height(texel_map.height), triangles(actor.neutral().triangles) {
        const Mesh& neutral = actor.neutral();
        const Points normals = vertex_normals(neutral.positions, triangles);
        const std::vector<Surface> surfaces = neutral.triangle_surfaces();
        const Places places(actor.landmarks());
        auto folds = fold_lines(places, std::uint32_t(seed * 0x9e3779b9u + 17));
        add_chin(places, folds);
        lay_bulges(places, neutral, normals, std::uint32_t(seed) + 301);
        const float s = places.scale(), ear = places.marks().ear[0].z();
        for (std::uint32_t i = 0; i < texel_map.texels.size(); ++i) {
            const TexelMap::Texel& at = texel_map.texels[i];
            if (at.triangle == TexelMap::kNone || surfaces[at.triangle] != Surface::skin) continue;
            const Triangle& c = triangles[at.triangle];
            const Site site{{c[0], c[1], c[2]}, {1 - at.b1 - at.b2, at.b1, at.b2}};
            const Vec3 p = site.position(neutral.positions);
            const Vec3 n = site.position(normals).normalized();
            const auto number = std::uint32_t(texels.size());
            const Pore pore = nearest_pore(p, std::uint32_t(seed) + 77);
            const float lips = smooth_step(-1, 1, places.into_lips(p));
            const float patchy = 0.65f + 0.5f * gradient_noise(p / (9 * s), std::uint32_t(seed) + 78);
            texels.push_back({i, c, at.b1, at.b2, pore.way - pore.way.dot(n) * n,
                              kPoreDepth * pore.size * std::clamp(patchy, 0.15f, 1.2f) * (1 - lips), 0.28f * (0.7f + 0.5f * pore.size)});
            if (p.z() < ear || n.z() < -0.2f) continue;
            const Vec2 flat = p.head<2>() + 0.45f * s * Vec2(gradient_noise(p / (5 * s), 5), gradient_noise(p / (5 * s), 6));
            for (std::size_t f = 0; f < folds.size(); ++f) {
                const Fold& fold = folds[f];
                const float room = kFoldReach * fold.width;
                if ((flat.array() < fold.low.array() - room).any() || (flat.array() > fold.high.array() + room).any()) continue;
                const Offset off = offset_from(fold.line, flat);
                const float ends = smooth_step(0, 0.16f, off.along) * smooth_step(1, 0.84f, off.along);
                if (std::abs(off.across) > room || ends <= 0) continue;
                Vec3 direction(off.direction.x(), off.direction.y(), 0);
                direction -= direction.dot(n) * n;
                if (direction.norm() < 0.2f) continue;
                // No fold gives way everywhere at once.
                const float threshold = 0.035f + 0.03f * (1 + gradient_noise(Vec3(4 * off.along, float(f) * 1.7f, 0.3f), 91));
                fold_texels.push_back({number, direction.normalized(), off.across, fold.width, kDeepest * fold.depth * ends, threshold});
            }
        }
    }

    /// How far a vertex can bulge: mm, per vertex. Fat over the cheek and the jaw line, the brow's ridge, the lips' corners, the chin.
    void lay_bulges(const Places& places, const Mesh& neutral, const Points& normals, std::uint32_t seed) {
        const Landmarks& marks = places.marks();
        const float s = places.scale();
        struct Mound {
            Vec3 centre;
            float radius, height;  // scaled mm, mm
        };
        std::vector<Mound> mounds = {{marks.glabella + Vec3(0, 2, 0) * s, 13, 1.6f}, {marks.chin + Vec3(0, 6, 0) * s, 15, 2.0f}};
        for (int side = 0; side < 2; ++side) {
            const float out = side == 1 ? 1.0f : -1.0f;
            const Vec3 mouth = side == 1 ? marks.upper_lip_line.back() : marks.upper_lip_line.front();
            mounds.push_back({marks.cheek[side], 24, 3.2f});
            mounds.push_back({line_point(marks.brow[side], 0.35f) + Vec3(0, 3, 0) * s, 13, 1.8f});
            mounds.push_back({mouth + Vec3(out * 11, -1, -4) * s, 11, 2.4f});
            mounds.push_back({0.5f * (mouth + marks.chin) + Vec3(out * 26, -8, -16) * s, 18, 2.0f});
        }
        bulge.resize(Eigen::Index(neutral.vertex_count()));
        for (Eigen::Index v = 0; v < bulge.size(); ++v) {
            const Vec3 p = neutral.positions.row(v).transpose();
            float fat = 0;
            for (const Mound& mound : mounds) {
                const float r = places.from(p, mound.centre) / mound.radius;
                fat += mound.height * std::exp(-r * r);
            }
            const float uneven = 1 + 0.55f * gradient_noise(p / (11 * s), seed) + 0.3f * gradient_noise(p / (5.5f * s), seed + 1);
            bulge[v] = normals(v, 2) > -0.3f && p.z() > marks.ear[0].z() ? fat * std::max(0.0f, uneven) : 0;
        }
        const std::vector<Surface> surfaces = neutral.triangle_surfaces();
        for (std::size_t t = 0; t < neutral.triangles.size(); ++t)
            if (surfaces[t] != Surface::skin)
                for (const std::uint32_t v : neutral.triangles[t]) bulge[v] = 0;
    }

    Stretch stretch;
    int width, height;
    std::vector<Triangle> triangles;
    Eigen::VectorXf bulge;  // V, mm
    std::vector<Texel> texels;
    std::vector<FoldTexel> fold_texels;
};

SkinRelief::SkinRelief(const Actor& actor, const TexelMap& texels, std::uint64_t seed)
    : laid_(std::make_unique<const Laid>(actor, texels, seed)) {}
SkinRelief::~SkinRelief() = default;
const Stretch& SkinRelief::stretch() const { return laid_->stretch; }

Points SkinRelief::bulged(PointsRef deformed, const Stretch::Field& strain) const {
    Points points = deformed;
    const Points normals = vertex_normals(points, laid_->triangles);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        if (laid_->bulge[v] == 0) continue;
        const float growth = strain(v, 0) + strain(v, 1) + strain(v, 2);
        // Skin that is pressed together gives way outward, late and then fast; stretched skin sinks a little.
        const float pressed = std::max(0.0f, -growth - 0.04f);
        const float out = 1 - std::exp(-std::pow(pressed / 0.22f, 1.3f));
        const float in = 0.22f * std::tanh(3 * std::max(0.0f, growth - 0.03f));
        points.row(v) += laid_->bulge[v] * (out - in) * normals.row(v);
    }
    return points;
}

FloatMap SkinRelief::fine(const Stretch::Field& strain) const {
    const Laid& laid = *laid_;
    FloatMap map(laid.width, laid.height, 1);
    const auto strain_at = [&](const Laid::Texel& texel) {
        return Eigen::Matrix<float, 1, 6>((1 - texel.b1 - texel.b2) * strain.row(texel.corners[0]) + texel.b1 * strain.row(texel.corners[1]) +
                                          texel.b2 * strain.row(texel.corners[2]));
    };
    for (const Laid::Texel& texel : laid.texels) {
        if (texel.pore_depth == 0) continue;
        const Eigen::Matrix<float, 1, 6> h = strain_at(texel);
        const Vec3 way = texel.pore + kSofter * times(h.data(), texel.pore);
        const float flat = std::clamp(1 - 1.8f * (h[0] + h[1] + h[2]), 0.25f, 1.7f);
        map.values[texel.place] = -texel.pore_depth * flat * std::exp(-way.squaredNorm() / (texel.pore_radius * texel.pore_radius));
    }
    for (const Laid::FoldTexel& fold : laid.fold_texels) {
        const Laid::Texel& texel = laid.texels[fold.texel];
        const Eigen::Matrix<float, 1, 6> h = strain_at(texel);
        const float pressed = fold_depth(-along(h.data(), fold.direction), fold.threshold);
        if (pressed > 0) map.values[texel.place] += fold.depth * pressed * fold_profile(fold.across, fold.width, pressed);
    }
    return map;
}

}  // namespace mien::samples
