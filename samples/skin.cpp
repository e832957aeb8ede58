#include "samples/skin.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "core/parallel.hpp"
#include "samples/occlusion.hpp"
#include "samples/skin_paint.hpp"
#include "samples/skin_strain.hpp"

namespace mien::samples {
namespace {

constexpr int kGutter = 16;  // texels; more than mip levels and 8 x 8 coding blocks reach at a chart's edge

/// sRGB by table: fine enough that every code of 0 .. 255 is reached.
class SrgbTable {
public:
    SrgbTable() {
        for (int i = 0; i <= kSteps; ++i)
            codes_[std::size_t(i)] = std::uint8_t(std::lround(255 * linear_to_srgb(float(i) / kSteps)));
    }
    std::uint8_t operator()(float linear) const {
        return codes_[std::size_t(std::clamp(linear, 0.0f, 1.0f) * kSteps + 0.5f)];
    }

private:
    static constexpr int kSteps = 16384;
    std::array<std::uint8_t, kSteps + 1> codes_;
};

const SrgbTable& srgb_table() {
    static const SrgbTable table;
    return table;
}

bool blocks_light(Surface s) {
    return s == Surface::skin || s == Surface::eye || s == Surface::teeth || s == Surface::mouth ||
           s == Surface::hair;
}

/// What part of a surface's light is left where it sees so much of the sky, 0 .. 1.
float light_left(Surface s, float open) {
    switch (s) {
        case Surface::eye:
        case Surface::cornea:
            return 0.15f + 0.85f * open * std::sqrt(open);  // wet, it keeps some light
        case Surface::teeth:
        case Surface::mouth:
            // Behind shut lips hardly any. What parted lips let in, wet walls hand on: at half of the sky nothing is missing.
            return smooth_step(-0.02f, 0.5f, open);
        default:
            // A little darker than the sky alone makes it: what light there is comes from few sides.
            return open * std::sqrt(open);
    }
}

std::vector<Triangle> blockers_of(const Mesh& mesh) {
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    std::vector<Triangle> blockers;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (blocks_light(surfaces[t])) blockers.push_back(mesh.triangles[t]);
    return blockers;
}

}  // namespace

struct Skin::Painted {
    struct Texel {
        std::uint32_t place;  // y * size + x
        Triangle corners;
        float b1, b2;
        float albedo[3];
        float perfusion, crease;
    };
    struct Copy {
        std::uint32_t to, from;
    };

    Painted(const Actor& actor, int texels_per_side, std::uint64_t seed, const Complexion& complexion)
        : size(texels_per_side),
          triangles(actor.neutral().triangles),
          map(make_texel_map(actor.neutral(), size, size)),
          strain(actor.neutral()),
          occlusion(actor.neutral().positions, blockers_of(actor.neutral())),
          reach(2.2f * (actor.landmarks().eye_centre[1] - actor.landmarks().eye_centre[0]).norm()) {
        paint(actor, complexion, seed);
        lay_gutter();
        const Mesh& neutral = actor.neutral();
        const std::vector<Surface> surfaces = neutral.triangle_surfaces();
        kind.assign(neutral.vertex_count(), Surface::skin);
        for (std::size_t t = 0; t < triangles.size(); ++t)
            for (const std::uint32_t v : triangles[t]) kind[v] = surfaces[t];
        begin.push_back(0);
        for (const auto& list : vertex_neighbours(neutral.vertex_count(), triangles)) {
            around.insert(around.end(), list.begin(), list.end());
            begin.push_back(std::uint32_t(around.size()));
        }
    }

    void paint(const Actor& actor, const Complexion& complexion, std::uint64_t seed) {
        const Mesh& neutral = actor.neutral();
        const Painter painter(neutral, actor.landmarks(), complexion, seed);
        const Points normals = vertex_normals(neutral.positions, triangles);
        const Eigen::VectorXf open = occlusion.at(neutral.positions, normals, reach);
        const std::vector<Surface> surfaces = neutral.triangle_surfaces();
        for (std::uint32_t i = 0; i < map.texels.size(); ++i) {
            const TexelMap::Texel& texel = map.texels[i];
            if (texel.triangle != TexelMap::kNone)
                texels.push_back({i, triangles[texel.triangle], texel.b1, texel.b2, {}, 0, 0});
        }
        constexpr std::int64_t kBatch = 4096;
        const auto count = std::int64_t(texels.size());
        parallel_for((count + kBatch - 1) / kBatch, [&](std::int64_t batch) {
            for (std::int64_t i = batch * kBatch; i < std::min(count, (batch + 1) * kBatch); ++i) {
                Texel& texel = texels[std::size_t(i)];
                const Site site{{texel.corners[0], texel.corners[1], texel.corners[2]},
                                {1 - texel.b1 - texel.b2, texel.b1, texel.b2}};
                const std::uint32_t t = map.texels[texel.place].triangle;
                Vec3 normal = site.position(normals);
                normal = normal.norm() > 1e-6f ? Vec3(normal.normalized()) : Vec3(Vec3::UnitZ());
                const Vec3 p = site.position(neutral.positions);
                float sky = 0;
                for (int k = 0; k < 3; ++k) sky += site.weights[k] * open[site.vertices[k]];
                const Pigment pigment = painter.paint(surfaces[t], p, normal, footprint(neutral, t), sky);
                for (int k = 0; k < 3; ++k) texel.albedo[k] = std::clamp(pigment.albedo[k], 0.002f, 0.95f);
                texel.perfusion = pigment.perfusion;
                texel.crease = pigment.crease;
            }
        });
    }

    // mm a texel spans on triangle t.
    float footprint(const Mesh& neutral, std::uint32_t t) const {
        const Triangle& c = neutral.triangles[t];
        const Vec3 ab = (neutral.positions.row(c[1]) - neutral.positions.row(c[0])).transpose();
        const Vec3 ac = (neutral.positions.row(c[2]) - neutral.positions.row(c[0])).transpose();
        const Triangle& uv = neutral.texcoord_triangles[t];
        const Vec2 p = neutral.texcoords[uv[1]] - neutral.texcoords[uv[0]],
                   q = neutral.texcoords[uv[2]] - neutral.texcoords[uv[0]];
        const float area = std::abs(p.x() * q.y() - p.y() * q.x()) * float(size) * float(size);
        return std::sqrt(ab.cross(ac).norm() / std::max(area, 1e-6f));
    }

    // Grows the charts by one ring of texels at a time; each new texel takes over its neighbour's source.
    void lay_gutter() {
        constexpr std::uint32_t kFree = 0xffffffffu;
        std::vector<std::uint32_t> source(map.texels.size(), kFree), ring, next;
        for (const Texel& texel : texels) {
            source[texel.place] = texel.place;
            ring.push_back(texel.place);
        }
        for (int step = 0; step < kGutter; ++step) {
            next.clear();
            for (const std::uint32_t i : ring) {
                const int x = int(i) % size, y = int(i) / size;
                constexpr int kSteps[8][2] = {{-1, 0},  {1, 0},  {0, -1}, {0, 1},
                                              {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
                for (const auto& [dx, dy] : kSteps) {
                    if (x + dx < 0 || x + dx >= size || y + dy < 0 || y + dy >= size) continue;
                    const auto j = std::uint32_t((y + dy) * size + x + dx);
                    if (source[j] != kFree) continue;
                    source[j] = source[i];
                    next.push_back(j);
                    gutter.push_back({j, source[i]});
                }
            }
            ring.swap(next);
        }
    }

    // How much blood a vertex holds beside neutral, and how deep wrinkles are.
    struct Flush {
        float blood, depth;
    };
    std::vector<Flush> flush(const Instant& instant, PointsRef deformed) const {
        const Strain::Field field = strain.at(deformed);
        // Knitting the brows, baring the teeth and shutting the eyes hard flush the whole face a little.
        static const std::array<int, 6> kEffort{arkit_index("BrowDownLeft"),  arkit_index("BrowDownRight"),
                                                arkit_index("NoseSneerLeft"), arkit_index("NoseSneerRight"),
                                                arkit_index("EyeSquintLeft"), arkit_index("EyeSquintRight")};
        float effort = 0;
        for (const int i : kEffort)
            effort += std::clamp(instant.weights[std::size_t(i)], 0.0f, 1.0f) / float(kEffort.size());
        std::vector<Flush> flushed(kind.size());
        for (std::size_t v = 0; v < flushed.size(); ++v) {
            // Squeezed skin holds more blood, up to a point; stretched skin can only lose what it had.
            const float growth = field.growth[Eigen::Index(v)];
            flushed[v].blood = (growth < 0 ? 0.9f : 0.38f) * std::tanh(-1.5f * growth) + 0.18f * effort;
            flushed[v].depth = std::clamp(1.6f * (field.squeeze[Eigen::Index(v)] - 0.05f), 0.0f, 1.0f);
        }
        return flushed;
    }

    // What varies from frame to frame, per vertex: light that comes in, blood, and how deep wrinkles are.
    std::vector<Eigen::Array4f> shade(const Instant& instant, PointsRef deformed) const {
        const Eigen::VectorXf open = occlusion.at(deformed, vertex_normals(deformed, triangles), reach);
        const std::vector<Flush> flushed = flush(instant, deformed);
        std::vector<Eigen::Array4f> shaded(kind.size());
        for (std::size_t v = 0; v < shaded.size(); ++v) {
            float sum = 0;
            for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i) sum += open[around[i]];
            const auto count = float(begin[v + 1] - begin[v]);
            const float light = count > 0 ? 0.5f * open[Eigen::Index(v)] + 0.5f / count * sum : 1.0f;
            shaded[v] = {light_left(kind[v], light), flushed[v].blood, flushed[v].depth, 0};
        }
        return shaded;
    }

    // The albedo under so much blood and so deep a fold.
    static float tinted(const Texel& texel, int k, float blood, float fold) {
        const float x = -blood * kBloodAbsorption[k] - fold * (0.45f + 0.6f * kBloodAbsorption[k]);
        return texel.albedo[k] * (1 + x * (1 + x * (0.5f + x * (1 / 6.0f))));  // e^x, near 0
    }

    int size;
    std::vector<Triangle> triangles;
    TexelMap map;
    Strain strain;
    Occlusion occlusion;
    float reach;
    std::vector<Texel> texels;
    std::vector<Copy> gutter;
    std::vector<Surface> kind;                 // V
    std::vector<std::uint32_t> begin, around;  // neighbours of v: around[begin[v]] .. around[begin[v + 1]]
};

Complexion Complexion::of_seed(std::uint64_t seed) {
    Complexion complexion;
    if (seed == 0) return complexion;
    Random random(seed * 7919 + 13);
    // Most skins are near the middle; hair and eyes darken with the skin.
    const float dark = std::pow(random.uniform(), 1.6f);
    complexion.melanin = 0.7f + 3.6f * dark;
    complexion.haemoglobin = random.uniform(0.85f, 1.15f);
    complexion.freckles = std::max(0.0f, random.uniform(-0.3f, 1.6f) * (1 - 1.3f * dark));
    complexion.beard_shadow = random.uniform() < 0.5f ? 0.0f : random.uniform(0.1f, 0.6f);
    const float fair = random.uniform() * (1 - smooth_step(0.1f, 0.5f, dark));
    complexion.hair = Vec3(0.030f, 0.018f, 0.012f) + fair * fair * Vec3(0.24f, 0.155f, 0.075f);
    const float light_eyes = random.uniform() * (1 - smooth_step(0.15f, 0.45f, dark));
    complexion.iris = Vec3(0.075f, 0.036f, 0.016f) + light_eyes * Vec3(0.075f, 0.165f, 0.21f);
    return complexion;
}

Skin::Skin(const Actor& actor, int size, std::uint64_t seed)
    : Skin(actor, size, seed, Complexion::of_seed(seed)) {}

Skin::Skin(const Actor& actor, int size, std::uint64_t seed, const Complexion& complexion) {
    assert(size >= 16 && size <= 8192);
    assert(actor.neutral().has_texcoords());
    painted_ = std::make_unique<const Painted>(actor, size, seed, complexion);
}

Skin::~Skin() = default;
Skin::Skin(Skin&&) noexcept = default;
Skin& Skin::operator=(Skin&&) noexcept = default;

Image Skin::texture(const Instant& instant, PointsRef deformed) const {
    const Painted& skin = *painted_;
    assert(deformed.rows() == Eigen::Index(skin.kind.size()));
    const std::vector<Eigen::Array4f> shaded = skin.shade(instant, deformed);
    const SrgbTable& encode = srgb_table();

    Image image(skin.size, skin.size, 3);
    std::array<std::int64_t, 3> sums{};
    for (const Painted::Texel& texel : skin.texels) {
        const auto& [a, b, c] = texel.corners;
        const Eigen::Array4f here =
            (1 - texel.b1 - texel.b2) * shaded[a] + texel.b1 * shaded[b] + texel.b2 * shaded[c];
        const float light = here[0], blood = here[1] * texel.perfusion, fold = here[2] * texel.crease;
        std::uint8_t* pixel = image.pixels.data() + std::size_t(texel.place) * 3;
        for (int k = 0; k < 3; ++k) {
            const float tinted = Painted::tinted(texel, k, blood, fold);
            // Light bounced about in a hollow of this colour: what is hidden stays warm (the sum over all
            // bounces).
            const float lit = tinted * light / (1 - tinted * (1 - light));
            pixel[k] = encode(lit);
            sums[std::size_t(k)] += pixel[k];
        }
    }
    // Far from all charts: the mean colour, which costs a codec nothing.
    if (skin.texels.empty()) return image;
    std::array<std::uint8_t, 3> mean;
    for (std::size_t k = 0; k < 3; ++k) mean[k] = std::uint8_t(sums[k] / std::int64_t(skin.texels.size()));
    for (std::size_t i = 0; i < skin.map.texels.size(); ++i)
        if (skin.map.texels[i].triangle == TexelMap::kNone)
            std::copy(mean.begin(), mean.end(), image.pixels.begin() + std::ptrdiff_t(3 * i));
    for (const Painted::Copy& copy : skin.gutter)
        std::copy_n(image.pixels.begin() + std::ptrdiff_t(3) * copy.from, 3,
                    image.pixels.begin() + std::ptrdiff_t(3) * copy.to);
    return image;
}

Image Skin::mask() const {
    Image mask(painted_->size, painted_->size, 1);
    for (const Painted::Texel& texel : painted_->texels) mask.pixels[texel.place] = 255;
    return mask;
}

FloatMap Skin::albedo(const Instant& instant, PointsRef deformed, float outside) const {
    const Painted& skin = *painted_;
    assert(deformed.rows() == Eigen::Index(skin.kind.size()));
    const std::vector<Painted::Flush> flushed = skin.flush(instant, deformed);
    FloatMap map(skin.size, skin.size, 3);
    map.values.assign(map.values.size(), outside);
    for (const Painted::Texel& texel : skin.texels) {
        const auto& [a, b, c] = texel.corners;
        const float w = 1 - texel.b1 - texel.b2;
        const float blood = texel.perfusion * (w * flushed[a].blood + texel.b1 * flushed[b].blood + texel.b2 * flushed[c].blood);
        const float fold = texel.crease * (w * flushed[a].depth + texel.b1 * flushed[b].depth + texel.b2 * flushed[c].depth);
        for (int k = 0; k < 3; ++k)
            map.values[std::size_t(texel.place) * 3 + std::size_t(k)] = Painted::tinted(texel, k, blood, fold);
    }
    return map;
}

FloatMap Skin::albedo() const {
    FloatMap map(painted_->size, painted_->size, 3);
    for (const Painted::Texel& texel : painted_->texels)
        std::copy_n(texel.albedo, 3, map.values.data() + std::size_t(texel.place) * 3);
    return map;
}

const TexelMap& Skin::texel_map() const {
    return painted_->map;
}

}  // namespace mien::samples
