#pragma once

#include <cmath>
#include <string>

#include "samples/actor.hpp"

namespace mien::samples {

/// A curved plate with the landmarks of a face: an actor small enough for tests of what does not depend on the head.
class FlatActor : public Actor {
public:
    FlatActor() {
        constexpr int kSide = 64;
        mesh_.positions.resize(kSide * kSide, 3);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const float u = float(x) / (kSide - 1) - 0.5f, v = float(y) / (kSide - 1) - 0.5f;
                mesh_.positions.row(y * kSide + x) << 170 * u, 240 * v, 100 - 160 * u * u;
                mesh_.texcoords.push_back({u + 0.5f, v + 0.5f});
            }
        for (int y = 0; y + 1 < kSide; ++y)
            for (int x = 0; x + 1 < kSide; ++x) {
                const auto a = std::uint32_t(y * kSide + x);
                mesh_.triangles.push_back({a, a + 1, a + kSide + 1});
                mesh_.triangles.push_back({a, a + kSide + 1, a + kSide});
            }
        mesh_.texcoord_triangles = mesh_.triangles;
        for (int side : {0, 1}) {
            const float out = side == 0 ? -1.f : 1.f;
            marks_.eye_centre[side] = Vec3(out * 32, 35, 85);
            for (int i = 0; i <= 8; ++i) {
                const float s = float(i) / 8, arch = std::sin(3.1416f * s);
                marks_.upper_lid[side].push_back(on(out * (19 + 26 * s), 35 + 5 * arch));
                marks_.lower_lid[side].push_back(on(out * (19 + 26 * s), 35 - 5 * arch));
                marks_.brow[side].push_back(on(out * (14 + 42 * s), 56 + 4 * arch));
            }
            marks_.nostril[side] = on(out * 8, -8);
            marks_.cheek[side] = on(out * 45, 5);
            marks_.ear[side] = Vec3(out * 85, 20, 0);
        }
        for (int i = 0; i <= 16; ++i) {
            const float s = float(i) / 16, arch = std::sin(3.1416f * s), x = -24 + 48 * s;
            marks_.upper_lip_outline.push_back(on(x, -35 + 8 * arch));
            marks_.lower_lip_outline.push_back(on(x, -35 - 9 * arch));
            marks_.upper_lip_line.push_back(on(x, -35 + 0.3f * arch));
            marks_.lower_lip_line.push_back(on(x, -35 - 0.3f * arch));
        }
        marks_.nose_tip = on(0, 0);
        marks_.chin = on(0, -65);
        marks_.glabella = on(0, 55);
    }
    const Mesh& neutral() const override { return mesh_; }
    const Landmarks& landmarks() const override { return marks_; }
    const std::vector<std::uint32_t>& rigid_vertices() const override { return rigid_; }
    Points deform(const Instant& instant) const override {
        Points points = mesh_.positions;
        points.col(1).array() -= instant.weights[std::size_t(arkit_index("JawOpen"))] * 10;
        return points;
    }

private:
    static Vec3 on(float x, float y) { return {x, y, 100 - 160 * (x / 170) * (x / 170)}; }
    Mesh mesh_;
    Landmarks marks_;
    std::vector<std::uint32_t> rigid_ = {0, 1, 2, 3};
};

}  // namespace mien::samples
