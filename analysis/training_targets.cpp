#include <cmath>
#include <limits>

#include "analysis/high_pass.hpp"
#include "analysis/training.hpp"

namespace mien::analysis {

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Vec3 on_triangle(PointsRef points, const Triangle& c, const TexelMap::Texel& at) {
    return (1 - at.b1 - at.b2) * points.row(c[0]).transpose() + at.b1 * points.row(c[1]).transpose() + at.b2 * points.row(c[2]).transpose();
}

}  // namespace

double texel_span(const Mesh& neutral, const model::DomainMap& domain, const std::vector<TexelMap::Texel>& where) {
    double sum = 0;
    for (std::size_t i = 0; i < where.size(); ++i) {
        const Triangle &c = neutral.triangles[where[i].triangle], &t = neutral.texcoord_triangles[where[i].triangle];
        const Vec3 ab = (neutral.positions.row(c[1]) - neutral.positions.row(c[0])).transpose(), ac = (neutral.positions.row(c[2]) - neutral.positions.row(c[0])).transpose();
        const Vec2 p = neutral.texcoords[t[1]] - neutral.texcoords[t[0]], q = neutral.texcoords[t[2]] - neutral.texcoords[t[0]];
        const float area = std::abs(p.x() * q.y() - p.y() * q.x()) * float(domain.width) * float(domain.height);
        sum += std::sqrt(ab.cross(ac).norm() / std::max(area, 1e-9f));
    }
    return where.empty() ? 1 : sum / double(where.size());
}

std::vector<TexelMap::Texel> domain_texels(const model::DomainMap& domain, const TexelMap& texels) {
    std::vector<TexelMap::Texel> where;
    where.reserve(domain.size());
    for (const std::uint32_t place : domain.place) where.push_back(texels.texels[place]);
    return where;
}

void medium_target(const FloatMap& scan, const Mesh& neutral, const model::DomainMap& domain, const std::vector<TexelMap::Texel>& where,
                   PointsRef base, float* out) {
    const std::size_t n = domain.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 p = on_triangle(base, neutral.triangles[where[i].triangle], where[i]);
        const float* seen = scan.values.data() + 3 * std::size_t(domain.place[i]);
        for (int c = 0; c < 3; ++c) out[std::size_t(c) * n + i] = seen[c] - p[c];
    }
}

FineTarget::FineTarget(const model::DetailModel& model, double sigma, FineOver over)
    : model_(model), sigma_(sigma), over_(over), surface_(model.neutral, model.medium_domain),
      medium_where_(domain_texels(model.medium_domain, make_texel_map(model.neutral, model.medium_domain.width, model.medium_domain.height, 1u << int(Surface::skin)))),
      where_(domain_texels(model.fine_domain, make_texel_map(model.neutral, model.fine_domain.width, model.fine_domain.height, 1u << int(Surface::skin)))) {
    const model::DomainMap& domain = model.fine_domain;
    const model::DomainSampler sampler(model.medium_domain);
    for (const std::uint32_t place : domain.place)
        samples_.push_back(sampler.at({(float(place % std::uint32_t(domain.width)) + 0.5f) / float(domain.width),
                                       1 - (float(place / std::uint32_t(domain.width)) + 0.5f) / float(domain.height)}));
}

void FineTarget::compute(const Scan& scan, PointsRef base, const float* medium, float* out) const {
    const model::DomainMap& domain = model_.fine_domain;
    const Points normals = vertex_normals(surface_.move(base, medium), model_.neutral.triangles);
    // Displacements are interpolated, not places: between texels these would cut the corners of the base shape.
    std::vector<float> scanned;
    if (over_ == FineOver::scan) {
        scanned.resize(3 * model_.medium_domain.size());
        medium_target(scan.medium, model_.neutral, model_.medium_domain, medium_where_, base, scanned.data());
    }
    const float* displacement = over_ == FineOver::scan ? scanned.data() : medium;
    FloatMap over(domain.width, domain.height, 1);
    over.values.assign(over.values.size(), kNaN);
    for (std::size_t i = 0; i < domain.size(); ++i) {
        if (samples_[i].count == 0) continue;
        const Triangle& corners = model_.neutral.triangles[where_[i].triangle];
        Vec3 p = on_triangle(base, corners, where_[i]);
        for (int c = 0; c < 3; ++c) p[c] += model::sampled(samples_[i], displacement, model_.medium_domain.size(), c);
        const Eigen::Map<const Vec3> seen(scan.fine.values.data() + 3 * std::size_t(domain.place[i]));
        over.values[domain.place[i]] = (seen - p).dot(on_triangle(normals, corners, where_[i]).normalized());
    }
    const FloatMap fine = high_pass(over, sigma_);
    for (std::size_t i = 0; i < domain.size(); ++i) out[i] = fine.values[domain.place[i]];
}

}  // namespace mien::analysis
