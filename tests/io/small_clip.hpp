#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string>

#include "io/clip_folder.hpp"
#include "io/texture_file.hpp"

/// Clips of few points, and what is said of them when they are loaded.
namespace mien::io::test {

/// A tetrahedron the size of a head.
inline Mesh small_head() {
    Mesh mesh;
    mesh.positions.resize(4, 3);
    mesh.positions << 0, 0, 0, 200, 0, 0, 0, 250, 0, 0, 0, 200;
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    mesh.texcoord_triangles = mesh.triangles;
    return mesh;
}

/// Everything a clip can have, 3 frames.
inline Clip full_clip() {
    Clip clip;
    clip.frame_rate = {30000, 1001};
    clip.unit = Unit::cm;
    clip.neutral = small_head();
    clip.vertices.emplace(3, 4);
    clip.markers.emplace(3, 2);
    clip.weights.emplace(3, 2);
    clip.weights->names = {"JawOpen", "Smile"};
    for (int f = 0; f < 3; ++f) {
        clip.vertices->frame(f) = clip.neutral->positions.array() + float(f);
        clip.markers->frame(f) << 1, 2, float(f), 4, 5, 6;
        clip.weights->frame(f)[0] = 0.25f * float(f);
        clip.head_pose.push_back({Eigen::Quaternionf(Eigen::AngleAxisf(0.1f * float(f), Vec3::UnitY())), Vec3(float(f), 2, 3)});
        clip.gaze.push_back({{0.1f, 0.2f}, {0.3f, 0.1f * float(f)}});
    }
    clip.markers->frame(1).row(0).setConstant(std::numeric_limits<float>::quiet_NaN());
    clip.marker_sites = {Site::at_vertex(2), {{3, 0, 1}, {0.5f, 0.25f, 0.25f}}};
    clip.blendshapes = {{"JawOpen", Points::Constant(4, 3, 1)}, {"Smile", Points::Constant(4, 3, -2)}};
    clip.rigid = {0, 3};
    std::vector<Image> frames(3, Image(5, 3, 3));
    for (int f = 0; f < 3; ++f) frames[std::size_t(f)].pixels.assign(45, std::uint8_t(50 * f));
    clip.texture = texture_of(std::move(frames));
    clip.mask = Image(5, 3, 1);
    clip.mask->pixels.assign(15, 255);
    clip.sound.emplace();
    clip.sound->samples.assign(4805, 0.5f);
    return clip;
}

inline void expect_message(const std::filesystem::path& path, std::initializer_list<const char*> words) {
    const auto loaded = load_clip(path);
    ASSERT_FALSE(loaded) << "loaded what should have been refused for " << *words.begin();
    for (const char* word : words) EXPECT_NE(loaded.error().message.find(word), std::string::npos) << loaded.error().message;
}

inline bool warns(const LoadedClip& loaded, const char* word) {
    for (const std::string& warning : loaded.warnings)
        if (warning.find(word) != std::string::npos) return true;
    return false;
}

}  // namespace mien::io::test
