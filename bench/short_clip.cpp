#include "bench/short_clip.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/hash.hpp"

namespace mien::bench {
namespace {

class FirstPictures final : public TextureSource {
public:
    FirstPictures(std::shared_ptr<TextureSource> source, std::int64_t frames) : source_(std::move(source)), frames_(frames) {}
    int width() const override { return source_->width(); }
    int height() const override { return source_->height(); }
    std::int64_t frames() const override { return frames_; }
    Result<Image> read(std::int64_t frame) override { return source_->read(frame); }

private:
    std::shared_ptr<TextureSource> source_;
    std::int64_t frames_;
};

/// Rings that run outward over a colour gradient.
class Rings final : public TextureSource {
public:
    static constexpr int kSide = 64;
    explicit Rings(std::int64_t frames) : frames_(frames) {}
    int width() const override { return kSide; }
    int height() const override { return kSide; }
    std::int64_t frames() const override { return frames_; }
    Result<Image> read(std::int64_t frame) override {
        Image image(kSide, kSide, 3);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const double wave = std::sin(std::hypot(x - 32.0, y - 32.0) / 3 - double(frame) / 2);
                image.at(x, y)[0] = std::uint8_t(128 + 60 * wave + x);
                image.at(x, y)[1] = std::uint8_t(100 + 40 * wave + y);
                image.at(x, y)[2] = std::uint8_t(90 + 30 * wave);
            }
        return image;
    }

private:
    std::int64_t frames_;
};

}  // namespace

Clip first_frames(const Clip& clip, std::int64_t frames) {
    Clip out = clip;
    out.sound.reset();
    if (clip.frame_count() <= frames) return out;
    const auto cut = [&](std::optional<PointSequence>& sequence) {
        if (!sequence) return;
        sequence->frames = frames;
        sequence->xyz.resize(std::size_t(frames * sequence->points * 3));
    };
    cut(out.vertices);
    cut(out.markers);
    if (out.weights) {
        out.weights->frames = frames;
        out.weights->values.resize(std::size_t(frames * out.weights->count));
    }
    if (!out.head_pose.empty()) out.head_pose.resize(std::size_t(frames));
    if (!out.gaze.empty()) out.gaze.resize(std::size_t(frames));
    if (out.texture && out.texture->frames() > frames) out.texture = std::make_shared<FirstPictures>(out.texture, frames);
    return out;
}

Clip sheet_clip() {
    constexpr int kSide = 20;
    constexpr std::int64_t kFrames = 12;
    Clip clip;
    clip.name = "sheet";
    clip.frame_rate = {12, 1};
    Mesh mesh;
    mesh.positions.resize(kSide * kSide, 3);
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            mesh.positions.row(y * kSide + x) =
                Vec3(10.f * float(x) - 95, 10.f * float(y) - 95, 20 * std::cos(float(x) / 6)).transpose();
            mesh.texcoords.push_back({float(x) / (kSide - 1), float(y) / (kSide - 1)});
        }
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
        for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
            const std::uint32_t v = y * kSide + x;
            mesh.triangles.push_back({v, v + 1, v + kSide});
            mesh.triangles.push_back({v + 1, v + kSide + 1, v + kSide});
        }
    mesh.texcoord_triangles = mesh.triangles;
    clip.vertices.emplace(kFrames, mesh.positions.rows());
    for (std::int64_t f = 0; f < kFrames; ++f) {
        PointsMap points = clip.vertices->frame(f);
        points = mesh.positions;
        for (Eigen::Index p = 0; p < points.rows(); ++p)
            points(p, 2) += 5 * std::sin(points(p, 0) / 30 + float(f) / 2) * std::cos(points(p, 1) / 50 - float(f) / 3);
    }
    clip.neutral = std::move(mesh);
    clip.texture = std::make_shared<Rings>(kFrames);
    return clip;
}

std::string clip_key(const Clip& clip) {
    Bytes all;
    const auto add = [&](const auto& numbers) {
        const auto bytes = std::as_bytes(std::span(numbers));
        const Hash hash = sha256(bytes);
        const auto digest = std::as_bytes(std::span(hash.bytes));
        all.insert(all.end(), digest.begin(), digest.end());
    };
    if (clip.vertices) add(clip.vertices->xyz);
    if (clip.markers) add(clip.markers->xyz);
    if (clip.weights) add(clip.weights->values);
    if (clip.neutral) add(clip.neutral->triangles);
    const std::int64_t numbers[] = {clip.frame_rate.num, clip.frame_rate.den, clip.frame_count(),
                                    clip.texture ? clip.texture->width() : 0, clip.texture ? clip.texture->height() : 0};
    add(numbers);
    if (clip.texture)
        if (const auto first = clip.texture->read(0); first.ok()) add(first->pixels);
    return clip.name + "#" + sha256(all).hex().substr(0, 8);
}

}  // namespace mien::bench
