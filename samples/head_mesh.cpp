#include "samples/head_mesh.hpp"

namespace mien::samples {

std::uint32_t HeadMeshBuilder::vertex(const Vec3d& position) {
    positions_.push_back(position);
    return vertex_count() - 1;
}

std::uint32_t HeadMeshBuilder::texcoord(const Vec2d& uv) {
    texcoords_.push_back(uv);
    return static_cast<std::uint32_t>(texcoords_.size() - 1);
}

void HeadMeshBuilder::triangle(Surface surface, Corner a, Corner b, Corner c) {
    parts_.back().second.push_back({surface, {a, b, c}});
}

void HeadMeshBuilder::quad(Surface surface, Corner a, Corner b, Corner c, Corner d) {
    // Cut towards the midline above and away from it below; ties of height go by the mirror-symmetric first
    // corner.
    const auto key = [&](Corner p, Corner q) {
        const Vec3d m = position(p.first), n = position(q.first);
        return std::abs(m.x()) * m.y() + std::abs(n.x()) * n.y() + 1e-3 * (m.z() + n.z());
    };
    const double one = (position(a.first) - position(c.first)).norm(),
                 two = (position(b.first) - position(d.first)).norm();
    bool first = std::abs(one - two) > 1e-6 ? one < two : key(a, c) < key(b, d);
    // But never so that the texture folds.
    const auto folds = [&](Corner p, Corner q, Corner r) {
        const Vec2d u = uv(q.second) - uv(p.second), v = uv(r.second) - uv(p.second);
        return u.x() * v.y() - u.y() * v.x() < 1e-9;
    };
    const bool first_folds = folds(a, b, c) || folds(a, c, d), other_folds = folds(a, b, d) || folds(b, c, d);
    if (first_folds != other_folds) first = other_folds;
    if (first) {
        triangle(surface, a, b, c);
        triangle(surface, a, c, d);
    } else {
        triangle(surface, a, b, d);
        triangle(surface, b, c, d);
    }
}

Mesh HeadMeshBuilder::build() const {
    Mesh mesh;
    mesh.positions.resize(vertex_count(), 3);
    for (std::uint32_t v = 0; v < vertex_count(); ++v) mesh.positions.row(v) = positions_[v].cast<float>();
    for (const Vec2d& uv : texcoords_) mesh.texcoords.push_back(uv.cast<float>());
    for (const auto& [name, triangles] : parts_) {
        // One run per surface, in the order of its first triangle.
        std::vector<Surface> surfaces;
        for (const Corners& t : triangles)
            if (std::find(surfaces.begin(), surfaces.end(), t.surface) == surfaces.end())
                surfaces.push_back(t.surface);
        for (const Surface surface : surfaces) {
            MeshPart part{name, surface, static_cast<std::uint32_t>(mesh.triangles.size()), 0};
            for (const Corners& t : triangles) {
                if (t.surface != surface) continue;
                mesh.triangles.push_back({t.corners[0].first, t.corners[1].first, t.corners[2].first});
                mesh.texcoord_triangles.push_back(
                    {t.corners[0].second, t.corners[1].second, t.corners[2].second});
                ++part.count;
            }
            if (surfaces.size() > 1 && surface == Surface::mouth) part.name += "_gums";
            if (surface == Surface::hair) part.name = "hair";
            mesh.parts.push_back(part);
        }
    }
    return mesh;
}

namespace {

HeadMesh assemble(const HeadSurface& surface) {
    HeadMesh head;
    HeadMeshBuilder builder;
    add_skin(surface, builder, head);
    add_eyeballs(surface, builder, head);
    add_teeth(surface, builder, head);
    add_lashes(surface, builder, head);
    head.mesh = builder.build();
    return head;
}

}  // namespace

HeadMesh make_head_mesh(const HeadSurface& surface) {
    HeadMesh head = assemble(surface);
    // Quads are cut by their shape: every seed takes the cuts of the plain head, so that all have the same
    // triangles.
    const HeadMesh plain = assemble(HeadSurface(HeadProportions{}));
    head.mesh.triangles = plain.mesh.triangles;
    head.mesh.texcoord_triangles = plain.mesh.texcoord_triangles;
    for (Eigen::Index v = 0; v < head.mesh.positions.rows(); ++v)
        head.mesh.positions.row(v) =
            surface.skewed(head.mesh.positions.row(v).transpose().cast<double>()).cast<float>();

    // Landmarks are read off the mesh itself, so that they lie exactly on it.
    const auto at = [&](std::uint32_t v) -> Vec3 { return head.mesh.positions.row(v).transpose(); };
    Landmarks& marks = head.landmarks;
    for (int side = 0; side < 2; ++side) {
        const float sign = side == 1 ? 1.f : -1.f;
        const auto mirrored = [&](const Vec3d& p) {
            return Vec3(surface.skewed({sign * p.x(), p.y(), p.z()}).cast<float>());
        };
        for (int i = 0; i <= 12; ++i) {
            const double q = i / 12.0;
            const double x = mix(12.5, 52, q), y = 19.6 + 3.8 * std::sin(pi * std::pow(q, 1.35)) - 2.6 * q * q;
            marks.brow[side].push_back(mirrored(surface.front(x, y)));
        }
        const auto& margin = head.lids[side].rings[HeadMesh::kLidMargin];
        const int n = static_cast<int>(margin.size());
        for (int k = n / 2; k >= 0; --k) marks.upper_lid[side].push_back(at(margin[k]));
        for (int k = n / 2; k <= n; ++k) marks.lower_lid[side].push_back(at(margin[k % n]));
        marks.eye_centre[side] = mirrored(surface.eye_centre());
        marks.nostril[side] = at(head.nostrils[side].rings[1][0]);
        for (const std::uint32_t v : head.nostrils[side].rings[1])
            marks.nostril[side] += (at(v) - marks.nostril[side]) / float(head.nostrils[side].size());
        marks.cheek[side] = mirrored(surface.front(40, -34));
        marks.ear[side] = at(head.ears[side].rings[kEarRings - 1][0]);
    }
    marks.eye_radius = float(surface.proportions().eye_radius);
    const int n = head.mouth.size();
    for (int k = n / 2; k >= 0; --k) {
        marks.upper_lip_outline.push_back(at(head.mouth.rings[HeadMesh::kLipBorder][k]));
        marks.upper_lip_line.push_back(at(head.mouth.rings[HeadMesh::kLipContact][k]));
    }
    for (int k = n / 2; k <= n; ++k) {
        marks.lower_lip_outline.push_back(at(head.mouth.rings[HeadMesh::kLipBorder][k % n]));
        marks.lower_lip_line.push_back(at(head.mouth.rings[HeadMesh::kLipContact][k % n]));
    }
    const auto on_midline = [&](double y) { return Vec3(surface.skewed(surface.front(0, y)).cast<float>()); };
    marks.nose_tip = on_midline(-34);
    for (double y = -30; y > -42; y -= 0.5)
        if (on_midline(y).z() > marks.nose_tip.z()) marks.nose_tip = on_midline(y);
    marks.chin = on_midline(-102);
    marks.glabella = on_midline(19);
    return head;
}

}  // namespace mien::samples
