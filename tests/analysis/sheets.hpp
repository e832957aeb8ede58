#pragma once

#include <cmath>
#include <memory>

#include "analysis/training.hpp"

namespace mien::analysis {

/// A slightly bent sheet of skin, 21 x 21 vertices 2 mm apart, texture coordinates over the whole picture.
inline Mesh sheet() {
    constexpr std::uint32_t kSide = 21;
    Mesh mesh;
    mesh.positions.resize(kSide * kSide, 3);
    for (std::uint32_t y = 0; y < kSide; ++y)
        for (std::uint32_t x = 0; x < kSide; ++x) {
            const float px = 2 * float(x) - 20, py = 2 * float(y) - 20;
            mesh.positions.row(y * kSide + x) << px, py, -0.005f * (px * px + py * py);
            mesh.texcoords.emplace_back(0.02f + 0.96f * float(x) / (kSide - 1), 0.02f + 0.96f * float(y) / (kSide - 1));
        }
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
        for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
            const std::uint32_t a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
            mesh.triangles.push_back({a, b, d});
            mesh.triangles.push_back({a, d, c});
        }
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

/// Markers on every fourth vertex that bend, shear and stretch in several independent ways.
inline Clip sheet_clip(std::int64_t frames) {
    Clip clip;
    clip.neutral = sheet();
    for (std::uint32_t y = 0; y < 21; y += 4)
        for (std::uint32_t x = 0; x < 21; x += 4) clip.marker_sites.push_back(Site::at_vertex(y * 21 + x));
    clip.markers.emplace(frames, std::int64_t(clip.marker_sites.size()));
    for (std::int64_t f = 0; f < frames; ++f) {
        const float a = 3 * std::sin(0.9f * float(f)), b = 2 * std::sin(2.3f * float(f) + 1) - 0.8f, c = std::cos(1.7f * float(f));
        for (std::size_t m = 0; m < clip.marker_sites.size(); ++m) {
            const Vec3 p = clip.marker_sites[m].position(clip.neutral->positions);
            const float sx = std::sin(p.x() / 14), cy = std::cos(p.y() / 17);
            clip.markers->frame(f).row(Eigen::Index(m)) = (f == 0 ? p : Vec3(p + Vec3(a * sx + 0.2f * c, b * cy, a * cy + b * sx))).transpose();
        }
        clip.head_pose.push_back({});
    }
    return clip;
}

/// Scans whose medium displacement and albedo are a given model's, exactly; the fine surface is the medium one.
class ModelScans : public ScanSource {
public:
    ModelScans(const Clip& clip, model::DetailModel truth, std::shared_ptr<const model::MarkerDriver> driver, int unseen_rows = 0)
        : clip_(clip), truth_(std::move(truth)), driver_(std::move(driver)), unseen_rows_(unseen_rows) {}
    std::int64_t frames() const override { return clip_.markers->frames; }
    int medium_size() const override { return truth_.medium_domain.width; }
    int fine_size() const override { return truth_.fine_domain.width; }
    bool has_albedo() const override { return true; }
    Result<Scan> read(std::int64_t frame, ScanParts) const override {
        const model::DrivenFrame driven = driver_->drive(clip_.markers->frame(frame), truth_.axes);
        Scan scan;
        scan.medium = surface(driven, truth_.medium_domain);
        scan.fine = surface(driven, truth_.fine_domain);
        std::vector<float> values(3 * truth_.fine_domain.size());
        model::evaluate_plain(truth_.albedo, truth_.fine_domain, driven.parameters, values.data());
        scan.albedo = model::spread(truth_.fine_domain, 3, values.data(), std::nanf(""));
        for (FloatMap* map : {&scan.medium, &scan.fine, &scan.albedo})
            std::fill_n(map->values.begin(), map->width * unseen_rows_ * 3, std::nanf(""));
        return scan;
    }

private:
    FloatMap surface(const model::DrivenFrame& driven, const model::DomainMap& domain) const {
        std::vector<float> values(3 * domain.size(), 0.0f);
        if (domain.size() == truth_.medium.texels) model::evaluate_plain(truth_.medium, domain, driven.parameters, values.data());
        const auto where = domain_texels(domain, make_texel_map(truth_.neutral, domain.width, domain.height));
        for (std::size_t i = 0; i < domain.size(); ++i) {
            const Triangle& c = truth_.neutral.triangles[where[i].triangle];
            const Site site{{c[0], c[1], c[2]}, {1 - where[i].b1 - where[i].b2, where[i].b1, where[i].b2}};
            const Vec3 p = site.position(driven.base);
            for (std::size_t k = 0; k < 3; ++k) values[k * domain.size() + i] += p[Eigen::Index(k)];
        }
        return model::spread(domain, 3, values.data(), std::nanf(""));
    }

    const Clip& clip_;
    model::DetailModel truth_;
    std::shared_ptr<const model::MarkerDriver> driver_;
    int unseen_rows_;
};

}  // namespace mien::analysis
