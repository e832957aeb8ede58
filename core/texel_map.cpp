#include "core/texel_map.hpp"

#include <algorithm>
#include <cmath>

namespace mien {

TexelMap make_texel_map(const Mesh& mesh, int width, int height, std::uint32_t surfaces) {
    TexelMap map{width, height, std::vector<TexelMap::Texel>(std::size_t(width) * height)};
    if (!mesh.has_texcoords()) return map;
    const std::vector<Surface> surface_of = mesh.triangle_surfaces();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!(surfaces >> int(surface_of[t]) & 1)) continue;
        Eigen::Vector2d p[3];
        for (int i = 0; i < 3; ++i) {
            const Vec2& uv = mesh.texcoords[mesh.texcoord_triangles[t][i]];
            p[i] = {uv.x() * width - 0.5, (1 - uv.y()) * height - 0.5};
        }
        const double area = (p[1] - p[0]).x() * (p[2] - p[0]).y() - (p[2] - p[0]).x() * (p[1] - p[0]).y();
        if (!(std::abs(area) > 1e-12)) continue;
        const auto [x_low, x_high] = std::minmax({p[0].x(), p[1].x(), p[2].x()});
        const auto [y_low, y_high] = std::minmax({p[0].y(), p[1].y(), p[2].y()});
        const int x0 = std::max(0, int(std::ceil(std::clamp(x_low, -1.0, 1e6)))), x1 = std::min(width - 1, int(std::floor(std::clamp(x_high, -1.0, 1e6))));
        const int y0 = std::max(0, int(std::ceil(std::clamp(y_low, -1.0, 1e6)))), y1 = std::min(height - 1, int(std::floor(std::clamp(y_high, -1.0, 1e6))));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const Eigen::Vector2d d(x - p[0].x(), y - p[0].y());
                const double b1 = (d.x() * (p[2] - p[0]).y() - (p[2] - p[0]).x() * d.y()) / area;
                const double b2 = ((p[1] - p[0]).x() * d.y() - d.x() * (p[1] - p[0]).y()) / area;
                constexpr double kEdge = -1e-9;  // texel centres on a shared edge must not fall between two triangles
                if (b1 < kEdge || b2 < kEdge || b1 + b2 > 1 - kEdge) continue;
                TexelMap::Texel& texel = map.texels[std::size_t(y) * width + x];
                if (texel.triangle == TexelMap::kNone) texel = {t, float(b1), float(b2)};
            }
    }
    return map;
}

}  // namespace mien
