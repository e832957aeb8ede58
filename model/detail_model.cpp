#include "model/detail_model.hpp"

#include <algorithm>
#include <cmath>

#include "model/thin_shell.hpp"

namespace mien::model {

DomainMap detail_domain(const DetailModel& model, int width, int height, const std::vector<std::uint8_t>& wanted) {
    return make_domain_map(model.neutral, make_texel_map(model.neutral, width, height, 1u << int(Surface::skin)), model.sites,
                           make_marker_mesh(model.neutral, model.sites, model.marker_triangles), model.reach, wanted);
}

MarkerDriver::MarkerDriver(const Mesh& neutral, const std::vector<Site>& sites, const std::vector<std::uint32_t>& fixed,
                           std::vector<Triangle> marker_triangles)
    : neutral_(neutral.positions), response_(thin_shell_response(neutral, sites, fixed)),
      meter_(make_marker_mesh(neutral, sites, std::move(marker_triangles))) {}

DrivenFrame MarkerDriver::drive(PointsRef markers, const DomainAxes& axes) const {
    Points there = markers;
    if (!fill_missing_markers(mesh(), there)) there = mesh().neutral;
    DrivenFrame frame;
    frame.S = meter_.measure(there);
    frame.parameters = domain_parameters(mesh(), axes, frame.S);
    frame.base = base(there);
    return frame;
}

DomainSampler::DomainSampler(const DomainMap& domain)
    : width_(domain.width), height_(domain.height), number_(std::size_t(domain.width) * std::size_t(domain.height), TexelMap::kNone) {
    for (std::uint32_t i = 0; i < domain.place.size(); ++i) number_[domain.place[i]] = i;
}

DomainSampler::Sample DomainSampler::at(const Vec2& uv) const {
    Sample sample;
    const float x = uv.x() * float(width_) - 0.5f, y = (1 - uv.y()) * float(height_) - 0.5f;
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    float sum = 0;
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const int xi = x0 + dx, yi = y0 + dy;
            if (xi < 0 || yi < 0 || xi >= width_ || yi >= height_) continue;
            const std::uint32_t number = number_[std::size_t(yi) * std::size_t(width_) + std::size_t(xi)];
            const float weight = (1 - std::abs(x - float(xi))) * (1 - std::abs(y - float(yi)));
            if (number == TexelMap::kNone || !(weight > 1e-4f)) continue;
            sample.texel[sample.count] = number;
            sample.weight[sample.count++] = weight;
            sum += weight;
        }
    for (int k = 0; k < sample.count; ++k) sample.weight[k] /= sum;
    return sample;
}

MediumSurface::MediumSurface(const Mesh& neutral, const DomainMap& medium_domain) : texels_(medium_domain.size()) {
    samples_.resize(neutral.vertex_count());
    const DomainSampler sampler(medium_domain);
    for (std::size_t t = 0; t < neutral.texcoord_triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            DomainSampler::Sample& sample = samples_[neutral.triangles[t][k]];
            if (sample.count == 0) sample = sampler.at(neutral.texcoords[neutral.texcoord_triangles[t][k]]);
        }
}

Points MediumSurface::move(PointsRef base, const float* medium) const {
    Points points = base;
    for (std::size_t v = 0; v < samples_.size(); ++v)
        for (int c = 0; c < 3; ++c) points(Eigen::Index(v), c) += sampled(samples_[v], medium, texels_, c);
    return points;
}

}  // namespace mien::model
