#include "model/detail_layers.hpp"

#include <cmath>

namespace mien::model {

DetailLayers::DetailLayers(DetailModel model)
    : model_(std::move(model)), meter_(make_marker_mesh(model_.neutral, model_.sites, model_.marker_triangles)),
      medium_surface_(model_.neutral, model_.medium_domain) {}

double DetailLayers::texels_a_mm() const {
    const std::vector<Vec2> uv = site_texcoords(model_.neutral, model_.sites);
    const Points& markers = meter_.mesh().neutral;
    double texels = 0, area = 0;
    for (const Triangle& t : model_.marker_triangles) {
        const Vec2 p = uv[t[1]] - uv[t[0]], q = uv[t[2]] - uv[t[0]];
        const Vec3 a = (markers.row(t[1]) - markers.row(t[0])).transpose(), b = (markers.row(t[2]) - markers.row(t[0])).transpose();
        texels += std::abs(double(p.x() * q.y() - p.y() * q.x())) / 2 * model_.fine_domain.width * model_.fine_domain.height;
        area += double(a.cross(b).norm()) / 2;
    }
    return area > 0 ? std::sqrt(texels / area) : 0;
}

DomainParameters DetailLayers::parameters(PointsRef base) const {
    Points markers(Eigen::Index(model_.sites.size()), 3);
    for (std::size_t m = 0; m < model_.sites.size(); ++m) markers.row(Eigen::Index(m)) = model_.sites[m].position(base).transpose();
    return domain_parameters(meter_.mesh(), model_.axes, meter_.measure(markers));
}

void DetailLayers::add_medium(const DomainParameters& parameters, Points& points) const {
    if (model_.medium.texels == 0) return;
    std::vector<float> values(std::size_t(model_.medium.channels) * model_.medium.texels);
    evaluate(model_.medium, model_.medium_domain, parameters, values.data());
    points = medium_surface_.move(points, values.data());
}

}  // namespace mien::model
