#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "core/clip.hpp"

/// Small clips with known truth.
namespace mien::motion_test {

inline Mesh sheet(std::uint32_t side) {
    Mesh mesh;
    mesh.positions.resize(side * side, 3);
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x)
            mesh.positions.row(y * side + x) << float(x) * 5, float(y) * 5, 20 * std::sin(float(x + y) * 0.1f);
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t a = y * side + x;
            mesh.triangles.push_back({a, a + 1, a + side});
            mesh.triangles.push_back({a + 1, a + side + 1, a + side});
        }
    return mesh;
}

/// Smooth bumps that come and go on the outer half of `at`; the first quarter of the points is still.
inline PointSequence bumps(PointsRef at, std::int64_t frames, unsigned seed, float noise = 0) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return float(random()) / 4294967296.0f; };
    struct Bump {
        Vec3 centre, direction;
        float frequency, phase, width;
    };
    std::vector<Bump> list;
    for (int i = 0; i < 4; ++i) {
        const Eigen::Index p = at.rows() / 4 + Eigen::Index(uniform() * float(at.rows() - at.rows() / 4 - 1));
        list.push_back({at.row(std::min(p, at.rows() - 1)).transpose(), Vec3(uniform() - 0.5f, uniform() - 0.5f, uniform()) * 6,
                        0.05f + 0.2f * uniform(), 6 * uniform(), 8 + 10 * uniform()});
    }
    PointSequence out(frames, at.rows());
    for (std::int64_t f = 0; f < frames; ++f) {
        PointsMap frame = out.frame(f);
        frame = at;
        for (Eigen::Index p = at.rows() / 4; p < at.rows(); ++p) {
            for (const Bump& b : list) {
                const float far = (at.row(p).transpose() - b.centre).norm() / b.width;
                frame.row(p) += (b.direction * std::exp(-far * far) * std::sin(b.frequency * float(f) + b.phase)).transpose();
            }
            for (int c = 0; c < 3 && noise > 0; ++c) frame(p, c) += noise * (uniform() + uniform() + uniform() - 1.5f) * 2;
        }
    }
    return out;
}

inline std::vector<RigidPose> nodding(std::int64_t frames) {
    std::vector<RigidPose> poses;
    for (std::int64_t f = 0; f < frames; ++f) {
        RigidPose pose;
        pose.rotation = Eigen::AngleAxisf(0.2f * std::sin(0.07f * float(f)), Vec3(1, 0.3f, 0).normalized());
        pose.translation = Vec3(3 * std::sin(0.05f * float(f)), 10, -4 * std::cos(0.03f * float(f)));
        poses.push_back(pose);
    }
    return poses;
}

inline Clip vertex_clip(std::uint32_t side, std::int64_t frames, unsigned seed, bool nods = false) {
    Clip clip;
    clip.neutral = sheet(side);
    clip.vertices = bumps(clip.neutral->positions, frames, seed);
    if (nods) {
        const auto poses = nodding(frames);
        for (std::int64_t f = 0; f < frames; ++f) apply_pose(poses[std::size_t(f)], clip.vertices->frame(f));
    }
    return clip;
}

inline Clip marker_clip(std::int64_t frames, unsigned seed, bool nods, double missing) {
    Clip clip;
    std::mt19937 random(seed);
    Points at(30, 3);
    for (float& x : at.reshaped()) x = float(random() % 1000) / 10;
    clip.markers = bumps(at, frames, seed, 0.02f);
    const auto poses = nodding(frames);
    for (std::int64_t f = 0; f < frames; ++f) {
        if (nods) apply_pose(poses[std::size_t(f)], clip.markers->frame(f));
        for (Eigen::Index p = 0; p < 30; ++p)
            if (double(random()) / 4294967296.0 < missing) clip.markers->frame(f).row(p).setConstant(std::nanf(""));
    }
    return clip;
}

inline Clip weight_clip(std::int64_t frames, unsigned seed) {
    Clip clip;
    std::mt19937 random(seed);
    clip.weights = WeightSequence(frames, 12);
    for (std::int64_t f = 0; f < frames; ++f)
        for (int i = 0; i < 12; ++i)
            clip.weights->frame(f)[i] = 0.5f + 0.5f * std::sin(float(f) * 0.05f * float(i % 5 + 1) + float(seed + unsigned(i)));
    return clip;
}

}  // namespace mien::motion_test
