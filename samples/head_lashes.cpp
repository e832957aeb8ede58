#include "samples/head_mesh.hpp"

namespace mien::samples {

void add_lashes(const HeadSurface& surface, HeadMeshBuilder& builder, HeadMesh& head) {
    using Corner = HeadMeshBuilder::Corner;
    const Vec3d eye = surface.eye_centre();
    for (int side = 0; side < 2; ++side) {
        builder.part(side ? "lashes_left" : "lashes_right");
        const auto& margin = head.lids[side].rings[HeadMesh::kLidMargin];
        const int n = static_cast<int>(margin.size()), half = n / 2;
        for (const bool upper : {true, false}) {
            // A bent card: first forward and towards the opening, then curling away from it.
            const double down = upper ? -0.35 : 0.25, curl = upper ? 0.45 : -0.35, length = upper ? 2.3 : 1.2;
            const Vec2d chart(side ? 0.71 : 0.12, upper ? 0.028 : 0.010), size(0.17, upper ? 0.022 : 0.010);
            std::vector<std::vector<Corner>> rows(3);
            for (int k = 2; k < 0.84 * half; ++k) {
                Vec3d root = builder.position(margin[upper ? k : n - k]);
                if (side == 0) root.x() = -root.x();
                const Vec3d d = (root - eye).normalized();
                // Lashes fan out to the temples, and are shortest at the nose.
                const double f = double(k) / half, grown = length * mix(1, 0.45, smooth_step(0.5, 0.84, f));
                const Vec3d middle =
                    root + (0.3 + grown) * (d + Vec3d(0.25 * (0.6 - f), down, 0.35)).normalized();
                const Vec3d tip =
                    middle + (0.3 + grown) * (d + Vec3d(0.35 * (0.6 - f), curl, 0.1)).normalized();
                for (int r = 0; r < 3; ++r) {
                    Vec3d p = r == 0 ? root + 0.05 * d : r == 1 ? middle : tip;
                    if (side == 0) p.x() = -p.x();
                    rows[r].push_back(builder.corner(
                        p,
                        chart + Vec2d(size.x() * (side == (upper ? 1 : 0) ? 1 - f : f), size.y() * r / 2)));
                    head.lashes[side].push_back({rows[r].back().first, k, upper});
                }
            }
            for (int r = 0; r < 2; ++r)
                for (std::size_t i = 0; i + 1 < rows[r].size(); ++i) {
                    // Outside is above for the upper lid and below for the lower; k runs from the temple to
                    // the nose.
                    if (upper == (side == 1))
                        builder.quad(Surface::lashes, rows[r][i], rows[r + 1][i], rows[r + 1][i + 1],
                                     rows[r][i + 1]);
                    else
                        builder.quad(Surface::lashes, rows[r][i + 1], rows[r + 1][i + 1], rows[r + 1][i],
                                     rows[r][i]);
                }
        }
    }
}

}  // namespace mien::samples
