#include "render/bust.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace mien::render {

std::optional<BustFade> bust_fade(const Mesh& neutral) {
    const std::vector<Surface> surfaces = neutral.triangle_surfaces();
    Eigen::AlignedBox3f eyes, all;
    for (std::size_t t = 0; t < neutral.triangles.size(); ++t)
        for (const std::uint32_t v : neutral.triangles[t]) {
            const Vec3 p = neutral.positions.row(v).transpose();
            all.extend(p);
            if (surfaces[t] == Surface::eye) eyes.extend(p);
        }
    if (eyes.isEmpty()) return std::nullopt;
    const float apart = eyes.sizes().x() - eyes.sizes().y();   // the box reaches from the outer side of one ball to that of the other
    const float chin = eyes.center().y() - 2.2f * apart, gone = all.min().y();
    if (!(apart > 0) || chin <= gone) return std::nullopt;
    return BustFade{gone, std::min(chin, gone + 0.7f * apart)};
}

}  // namespace mien::render
