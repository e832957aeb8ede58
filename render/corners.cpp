#include "render/corners.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <tuple>

namespace mien::render {
namespace {

constexpr std::array kDrawingOrder = {Surface::skin, Surface::hair, Surface::other, Surface::eye, Surface::teeth,
                                      Surface::mouth, Surface::lashes, Surface::cornea};

/// The number of the connected piece that each vertex of the given triangles belongs to.
std::vector<std::uint32_t> pieces_of(std::uint32_t V, const std::vector<Triangle>& triangles) {
    std::vector<std::uint32_t> parent(V);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Triangle& t : triangles)
        for (int i = 1; i < 3; ++i) parent[root(t[i])] = root(t[0]);
    for (std::uint32_t v = 0; v < V; ++v) parent[v] = root(v);
    return parent;
}

std::vector<std::uint32_t> vertices_of(const std::vector<Triangle>& triangles) {
    std::vector<std::uint32_t> vertices;
    for (const Triangle& t : triangles) vertices.insert(vertices.end(), t.begin(), t.end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

/// Eyeballs of a mesh: per vertex the sphere it lies on. The model knows them, or their shape tells.
void place_eyes(const model::FaceModel& model, const std::vector<Triangle>& eyes, std::vector<Sphere>& features) {
    const Points& p = model.neutral.positions;
    const std::vector<std::uint32_t> pieces = pieces_of(model.neutral.vertex_count(), eyes);
    std::map<std::uint32_t, std::vector<std::uint32_t>> by_piece;
    for (const std::uint32_t v : vertices_of(eyes)) by_piece[pieces[v]].push_back(v);
    for (const auto& [piece, rows] : by_piece) {
        const Sphere sphere = fit_sphere(p, rows);
        for (const std::uint32_t v : rows) features[v] = sphere;
    }
    for (const auto& eye : model.eyes) {
        if (!eye || eye->vertices.empty()) continue;
        float radius = 0;
        for (const std::uint32_t v : eye->vertices) radius += (p.row(v).transpose() - eye->centre).norm();
        radius /= float(eye->vertices.size());
        for (const std::uint32_t v : eye->vertices) features[v] = {eye->centre, std::max(radius, 1e-3f)};
    }
}

/// Lashes, tear films and corneas belong to the eyeball they are nearest to.
void place_around_eyes(const Points& positions, const std::vector<Triangle>& eyes, const std::vector<Triangle>& around,
                       std::vector<Sphere>& features) {
    std::vector<Sphere> balls;
    for (const std::uint32_t v : vertices_of(eyes))
        if (std::none_of(balls.begin(), balls.end(), [&](const Sphere& b) { return b.centre == features[v].centre; }))
            balls.push_back(features[v]);
    for (const std::uint32_t v : vertices_of(around)) {
        const auto distance = [&](const Sphere& b) { return (positions.row(v).transpose() - b.centre).squaredNorm(); };
        const auto nearest = std::min_element(balls.begin(), balls.end(), [&](const Sphere& a, const Sphere& b) {
            return distance(a) < distance(b);
        });
        if (nearest != balls.end()) features[v] = *nearest;
    }
}

/// The mouth: z of the front teeth, and a depth over which light fades behind them.
void place_mouth(const model::FaceModel& model, const std::vector<Triangle>& inside, const std::vector<Triangle>& teeth,
                 std::vector<Sphere>& features) {
    constexpr float kDepth = 22;  // mm: behind the first molars little light is left
    const Points& p = model.neutral.positions;
    const std::vector<std::uint32_t> front = vertices_of(teeth.empty() ? inside : teeth);
    float z = -1e30f;
    for (const std::uint32_t v : front) z = std::max(z, p(v, 2));
    for (const auto* list : {&inside, &teeth})
        for (const std::uint32_t v : vertices_of(*list)) features[v] = {Vec3(0, 0, z), kDepth};
}

bool inside_picture(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
    if (!mesh.has_texcoords()) return false;
    constexpr float kSlack = 1e-3f;
    for (const std::uint32_t t : triangles)
        for (const std::uint32_t c : mesh.texcoord_triangles[t]) {
            const Vec2& uv = mesh.texcoords[c];
            if (!(uv.minCoeff() >= -kSlack && uv.maxCoeff() <= 1 + kSlack)) return false;
        }
    return true;
}

}  // namespace

Sphere fit_sphere(PointsRef points, const std::vector<std::uint32_t>& rows) {
    // |x|^2 = 2 c.x + (r^2 - |c|^2), linear in c and the last term; about the mean, for its numbers.
    Vec3 mean = Vec3::Zero();
    for (const std::uint32_t v : rows) mean += points.row(v).transpose();
    if (!rows.empty()) mean /= float(rows.size());
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const std::uint32_t v : rows) {
        const Eigen::Vector3d x = (points.row(v).transpose() - mean).cast<double>();
        const Eigen::Vector4d row(2 * x.x(), 2 * x.y(), 2 * x.z(), 1);
        normal += row * row.transpose();
        right += row * x.squaredNorm();
    }
    normal.diagonal().array() += 1e-9;
    const Eigen::Vector4d solved = normal.ldlt().solve(right);
    const double squared = solved[3] + solved.head<3>().squaredNorm();
    return {mean + solved.head<3>().cast<float>(), float(std::sqrt(std::max(squared, 1e-6)))};
}

Corners make_corners(const model::FaceModel& model) {
    const Mesh& mesh = model.neutral;
    const std::vector<Surface> surfaces = mesh.triangle_surfaces();
    std::map<Surface, std::vector<std::uint32_t>> by_surface;
    std::map<Surface, std::vector<Triangle>> triangles;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        by_surface[surfaces[t]].push_back(t);
        triangles[surfaces[t]].push_back(mesh.triangles[t]);
    }
    std::vector<Sphere> features(mesh.vertex_count());
    const std::vector<Triangle>& eyes = triangles[Surface::eye];
    place_eyes(model, triangles[Surface::cornea], features);
    place_eyes(model, eyes, features);
    for (const Surface around : {Surface::lashes, Surface::cornea})
        place_around_eyes(mesh.positions, eyes, triangles[around], features);
    place_mouth(model, triangles[Surface::mouth], triangles[Surface::teeth], features);

    Corners result;
    std::map<std::tuple<std::uint32_t, std::uint32_t>, std::uint32_t> known;
    for (const Surface surface : kDrawingOrder) {
        std::vector<std::uint32_t>& members = by_surface[surface];
        if (members.empty()) continue;
        // What faces the front first: seen from the front half, much of the rest then fails the depth test unshaded. No
        // finer order, since neighbours in the list share their vertices' work.
        std::stable_partition(members.begin(), members.end(), [&](std::uint32_t t) {
            const Triangle& v = mesh.triangles[t];
            const Vec3 a = mesh.positions.row(v[0]), b = mesh.positions.row(v[1]), c = mesh.positions.row(v[2]);
            return (b - a).cross(c - a).z() > 0;
        });
        Batch batch{surface, inside_picture(mesh, members), std::uint32_t(result.indices.size()), 0};
        for (const std::uint32_t t : members)
            for (int i = 0; i < 3; ++i) {
                const std::uint32_t v = mesh.triangles[t][i];
                const std::uint32_t c = mesh.has_texcoords() ? mesh.texcoord_triangles[t][i] : 0;
                const auto [at, fresh] = known.try_emplace({v, c}, std::uint32_t(result.corners.size()));
                if (fresh) {
                    const Vec2 uv = mesh.has_texcoords() ? mesh.texcoords[c] : Vec2(0, 0);
                    const Sphere& f = features[v];
                    result.corners.push_back({v, uv.x(), uv.y(), {f.centre.x(), f.centre.y(), f.centre.z(), f.radius}});
                }
                result.indices.push_back(at->second);
            }
        batch.count = std::uint32_t(result.indices.size()) - batch.first;
        result.batches.push_back(batch);
    }
    return result;
}

}  // namespace mien::render
