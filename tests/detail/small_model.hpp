#pragma once

#include "analysis/texture_triangulation.hpp"
#include "model/term_basis.hpp"
#include "tests/analysis/sheets.hpp"

namespace mien {

/// A detail model over the bent sheet of the training tests with maps of known, skin-like content: smooth waves and a little relief.
struct SmallModel {
    Clip clip = analysis::sheet_clip(40);
    model::DetailModel model;
    model::TermMoments moments;

    explicit SmallModel(int medium_size = 32, int fine_size = 48, model::PolynomialOrder order = model::PolynomialOrder::biquadratic) {
        model.neutral = *clip.neutral;
        model.sites = clip.marker_sites;
        model.marker_triangles = analysis::triangulate_over_texture(model.neutral, model.sites);
        const model::MarkerDriver driver(model.neutral, model.sites, {}, model.marker_triangles);
        analysis::DeformationMoments deformations(driver.mesh());
        for (std::int64_t f = 0; f < clip.markers->frames; ++f) deformations.add(driver.meter().measure(clip.markers->frame(f)));
        model.axes = analysis::deformation_axes(deformations);
        Eigen::VectorXf longest;
        for (std::int64_t f = 0; f < clip.markers->frames; ++f) {
            const model::Deformations S = driver.meter().measure(clip.markers->frame(f));
            model::add_term_moments(moments, model.axes, S, 1 / double(clip.markers->frames));
            model::add_extents(longest, model.axes, S);
        }
        model.axes.extents = longest;
        model.medium_domain = model::detail_domain(model, medium_size, medium_size);
        model.fine_domain = model::detail_domain(model, fine_size, fine_size);
        model.medium = waves(3, order, model.medium_domain, 0.8f);
        model.fine = waves(1, order, model.fine_domain, 0.05f);
        model.albedo = waves(3, order, model.fine_domain, 0.04f);
    }

private:
    static model::PolynomialMap waves(int channels, model::PolynomialOrder order, const model::DomainMap& domain, float size) {
        model::PolynomialMap map(channels, order, domain.size());
        for (int c = 0; c < channels; ++c)
            for (int k = 0; k < model::term_count(order); ++k)
                for (std::size_t i = 0; i < map.texels; ++i) {
                    const float x = float(domain.place[i] % std::uint32_t(domain.width)), y = float(domain.place[i] / std::uint32_t(domain.width));
                    map.plane(c, k)[i] = size / float(1 + k) * (std::sin(0.2f * x + float(c)) * std::cos(0.13f * y + float(k)) + 0.1f * std::sin(2.1f * x + 1.3f * y));
                }
        return map;
    }
};

}  // namespace mien
