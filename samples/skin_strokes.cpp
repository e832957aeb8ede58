#include "samples/skin_strokes.hpp"

#include <algorithm>
#include <cmath>

namespace mien::samples {

SurfaceSampler::SurfaceSampler(const Mesh& mesh, std::uint32_t surfaces)
    : mesh_(mesh),
      normals_(vertex_normals(mesh.positions, mesh.triangles)),
      surfaces_(mesh.triangle_surfaces()) {
    float sum = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!(surfaces >> int(surfaces_[t]) & 1)) continue;
        const Triangle& c = mesh.triangles[t];
        const Vec3 ab = (mesh.positions.row(c[1]) - mesh.positions.row(c[0])).transpose();
        const Vec3 ac = (mesh.positions.row(c[2]) - mesh.positions.row(c[0])).transpose();
        sum += ab.cross(ac).norm() / 2;
        triangles_.push_back(t);
        cumulative_.push_back(sum);
    }
}

SurfaceSampler::Place SurfaceSampler::draw(Random& random) const {
    const float at = random.uniform() * area();
    const auto found = std::lower_bound(cumulative_.begin(), cumulative_.end(), at);
    const std::size_t i =
        std::min<std::size_t>(std::size_t(found - cumulative_.begin()), cumulative_.size() - 1);
    const Triangle& c = mesh_.triangles[triangles_[i]];
    float u = random.uniform(), v = random.uniform();
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    const auto mix = [&](const Points& rows) -> Vec3 {
        return ((1 - u - v) * rows.row(c[0]) + u * rows.row(c[1]) + v * rows.row(c[2])).transpose();
    };
    return {mix(mesh_.positions), mix(normals_).normalized(), surfaces_[triangles_[i]]};
}

std::uint64_t StrokeField::key(int x, int y, int z) {
    return std::uint64_t(x + 100000) << 42 ^ std::uint64_t(y + 100000) << 21 ^ std::uint64_t(z + 100000);
}

void StrokeField::add(const Stroke& stroke) {
    const auto index = std::uint32_t(strokes_.size());
    strokes_.push_back(stroke);
    const float reach = std::max(stroke.radius_root, stroke.radius_tip) + stroke.softness + 0.7f;
    const Vec3 low = stroke.a.cwiseMin(stroke.b).cwiseMin(stroke.c) - Vec3::Constant(reach);
    const Vec3 high = stroke.a.cwiseMax(stroke.b).cwiseMax(stroke.c) + Vec3::Constant(reach);
    const auto cell = [](float v) { return int(std::floor(v / kCell)); };
    for (int z = cell(low.z()); z <= cell(high.z()); ++z)
        for (int y = cell(low.y()); y <= cell(high.y()); ++y)
            for (int x = cell(low.x()); x <= cell(high.x()); ++x) cells_[key(x, y, z)].push_back(index);
}

void StrokeField::paint(const Vec3& p, const Vec3& normal, float footprint, Vec3& albedo) const {
    const auto cell = [](float v) { return int(std::floor(v / kCell)); };
    const auto found = cells_.find(key(cell(p.x()), cell(p.y()), cell(p.z())));
    if (found == cells_.end()) return;
    const float blur = footprint * 0.6f;
    for (const std::uint32_t i : found->second) {
        const Stroke& s = strokes_[i];
        if (s.normal.dot(normal) < 0.2f) continue;  // the other side of a thin fold, as of an ear
        float best = 1e9f, where = 0;
        const Vec3* corner[3] = {&s.a, &s.b, &s.c};
        for (int k = 0; k < 2; ++k) {
            const Vec3 ab = *corner[k + 1] - *corner[k], ap = p - *corner[k];
            const float t = std::clamp(ap.dot(ab) / std::max(1e-6f, ab.squaredNorm()), 0.0f, 1.0f);
            Vec3 off = ap - t * ab;
            const float height = off.dot(s.normal);
            if (std::abs(height) > 4) continue;
            off -= height * s.normal;
            const float distance = off.squaredNorm();
            if (distance < best) {
                best = distance;
                where = (float(k) + t) / 2;
            }
        }
        const float radius = s.radius_root + (s.radius_tip - s.radius_root) * where;
        const float edge = s.softness + blur, distance = std::sqrt(best);
        if (distance > radius + edge) continue;
        // However wide the blur, the hair keeps its weight.
        const float weight = std::min(1.0f, (2 * radius + s.softness) / (radius + edge));
        const float cover =
            s.opacity * weight * smooth_step(radius + edge, std::max(0.0f, radius - edge), distance);
        if (s.mode == Stroke::Mode::cover)
            albedo += cover * (s.tint - albedo);
        else
            albedo = albedo.cwiseProduct(Vec3::Ones() + cover * (s.tint - Vec3::Ones()));
    }
}

}  // namespace mien::samples
