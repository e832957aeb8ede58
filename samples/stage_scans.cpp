#include "samples/stage_scans.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "samples/noise.hpp"

namespace mien::samples {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint32_t kSkin = 1u << int(Surface::skin);

std::vector<std::uint8_t> seen_from_front(const Actor& actor, const TexelMap& texels) {
    const Mesh& neutral = actor.neutral();
    const Points normals = vertex_normals(neutral.positions, neutral.triangles);
    const Landmarks& marks = actor.landmarks();
    const float back = marks.ear[0].z(), bottom = marks.chin.y() - 0.5f * (marks.nose_tip.y() - marks.chin.y());
    std::vector<std::uint8_t> seen(texels.texels.size(), 0);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const TexelMap::Texel& texel = texels.texels[i];
        if (texel.triangle == TexelMap::kNone) continue;
        const Triangle& c = neutral.triangles[texel.triangle];
        const Site site{{c[0], c[1], c[2]}, {1 - texel.b1 - texel.b2, texel.b1, texel.b2}};
        const Vec3 p = site.position(neutral.positions);
        seen[i] = site.position(normals).normalized().z() > -0.1f && p.z() > back && p.y() > bottom;
    }
    return seen;
}

}  // namespace

StageScans::StageScans(std::shared_ptr<const Actor> actor, std::vector<Instant> instants, const ScannerOptions& options)
    : actor_(std::move(actor)), instants_(std::move(instants)), options_(options),
      medium_texels_(make_texel_map(actor_->neutral(), options.medium_size, options.medium_size, kSkin)),
      fine_texels_(make_texel_map(actor_->neutral(), options.fine_size, options.fine_size, kSkin)),
      medium_seen_(seen_from_front(*actor_, medium_texels_)), fine_seen_(seen_from_front(*actor_, fine_texels_)),
      relief_(*actor_, fine_texels_, options.seed) {
    if (options.albedo) skin_ = std::make_unique<const Skin>(*actor_, options.fine_size, options.seed);
}

FloatMap StageScans::positions(const TexelMap& texels, const std::vector<std::uint8_t>& seen, PointsRef points, PointsRef normals, const FloatMap* height) const {
    FloatMap map(texels.width, texels.height, 3);
    map.values.assign(map.values.size(), kNaN);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (!seen[i]) continue;
        const TexelMap::Texel& texel = texels.texels[i];
        const Triangle& c = actor_->neutral().triangles[texel.triangle];
        const Site site{{c[0], c[1], c[2]}, {1 - texel.b1 - texel.b2, texel.b1, texel.b2}};
        Vec3 p = site.position(points);
        if (height) p += height->values[i] * site.position(normals).normalized();
        Eigen::Map<Vec3>(map.values.data() + 3 * i) = p;
    }
    return map;
}

void StageScans::spoil(std::int64_t frame, std::uint64_t kind, double noise, FloatMap& map) const {
    if (noise == 0 && options_.holes == 0) return;
    Random random((options_.seed * 4 + kind) * 0x9e3779b97f4a7c15ull + std::uint64_t(frame) * 0xd1b54a32d192ed03ull);
    const auto seed = std::uint32_t(options_.seed * 977 + std::uint64_t(frame));
    // Gradient noise of one octave has about this spread; the share is met to within a few parts in a hundred.
    constexpr float edge = 0.26f * 1.41421356f;
    const float share = float(options_.holes);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            float* p = map.at(x, y);
            if (share > 0) {
                const float n = gradient_noise(Vec3(14 * (float(x) + 0.5f) / float(map.width), 14 * (float(y) + 0.5f) / float(map.height), 0.5f), seed);
                if (0.5f * std::erfc(-n / edge) < share) p[0] = p[1] = p[2] = kNaN;
            }
            for (int k = 0; k < 3 && noise > 0; ++k) p[k] += float(noise) * random.normal();
        }
}

Result<Scan> StageScans::read(std::int64_t frame, ScanParts parts) const {
    if (frame < 0 || frame >= frames()) return Error{ErrorCode::invalid, fmt::format("there is no scan of frame {}", frame)};
    const Instant& instant = instants_[std::size_t(frame)];
    const Points deformed = actor_->deform(instant);
    Scan scan;
    if (parts.medium || parts.fine) {
        const Stretch::Field strain = relief_.stretch().at(deformed);
        const Points surface = relief_.bulged(deformed, strain);
        const Points normals = vertex_normals(surface, actor_->neutral().triangles);
        if (parts.medium) {
            scan.medium = positions(medium_texels_, medium_seen_, surface, normals, nullptr);
            spoil(frame, 0, options_.noise, scan.medium);
        }
        if (parts.fine) {
            const FloatMap height = relief_.fine(strain);
            scan.fine = positions(fine_texels_, fine_seen_, surface, normals, &height);
            spoil(frame, 1, options_.noise, scan.fine);
        }
    }
    if (parts.albedo && skin_) {
        scan.albedo = skin_->albedo(instant, deformed, kNaN);
        for (std::size_t i = 0; i < fine_seen_.size(); ++i)
            if (!fine_seen_[i]) std::fill_n(scan.albedo.values.begin() + std::ptrdiff_t(3 * i), 3, kNaN);
        spoil(frame, 2, 0, scan.albedo);
    }
    return scan;
}

}  // namespace mien::samples
