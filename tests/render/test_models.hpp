#pragma once

#include <random>

#include "model/face_model.hpp"

namespace mien::render {

/// A sphere of quads cut into triangles, radius mm, with texture coordinates over the whole picture (u around, v up).
inline Mesh make_ball(float radius, int rings = 24, int sectors = 32) {
    Mesh mesh;
    mesh.positions.resize((rings + 1) * (sectors + 1), 3);
    for (int r = 0; r <= rings; ++r)
        for (int s = 0; s <= sectors; ++s) {
            const float polar = float(M_PI) * float(r) / float(rings), around = 2 * float(M_PI) * float(s) / float(sectors);
            mesh.positions.row(r * (sectors + 1) + s) =
                radius * Eigen::RowVector3f(std::sin(polar) * std::sin(around), -std::cos(polar), -std::sin(polar) * std::cos(around));
            mesh.texcoords.emplace_back(float(s) / float(sectors), float(r) / float(rings));
        }
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const auto a = std::uint32_t(r * (sectors + 1) + s), b = a + 1, c = a + std::uint32_t(sectors) + 1, d = c + 1;
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({b, c, d});
        }
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

/// A square of side mm in the plane z = 0 that faces +z, the whole picture on it.
inline Mesh make_card(float side) {
    Mesh mesh;
    mesh.positions.resize(4, 3);
    const float h = side / 2;
    mesh.positions << -h, -h, 0, h, -h, 0, h, h, 0, -h, h, 0;
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.texcoords = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

/// A board of skin, 160 mm wide, from y = 110 down to `bottom`, and two eyeballs at y = 0 before it, 63 mm apart.
inline Mesh make_bust(float bottom) {
    Mesh bust = make_card(160);
    bust.positions.col(1) << bottom, bottom, 110, 110;
    bust.parts = {{"skin", Surface::skin, 0, 2}};
    bust.texcoords.clear();
    bust.texcoord_triangles.clear();
    for (const float x : {-31.5f, 31.5f}) {
        const Mesh ball = make_ball(12);
        const auto first = bust.vertex_count();
        bust.parts.push_back({"eye", Surface::eye, std::uint32_t(bust.triangles.size()), std::uint32_t(ball.triangles.size())});
        bust.positions.conservativeResize(first + ball.vertex_count(), 3);
        bust.positions.bottomRows(ball.vertex_count()) = ball.positions.rowwise() + Eigen::RowVector3f(x, 0, 5);
        for (const Triangle& t : ball.triangles) bust.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return bust;
}

inline model::LinearMotion random_motion(Eigen::Index dimension, Eigen::Index k, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    model::LinearMotion motion;
    motion.mean = Eigen::VectorXf::NullaryExpr(dimension, [&] { return normal(random); });
    motion.components = Eigen::MatrixXf::NullaryExpr(dimension, k, [&] { return 0.02f * normal(random); });
    return motion;
}

}  // namespace mien::render
