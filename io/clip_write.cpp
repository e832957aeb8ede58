#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "core/environment_error.hpp"
#include "core/unfinished.hpp"
#include "io/clip_folder.hpp"
#include "io/file.hpp"
#include "io/image_file.hpp"
#include "io/npy.hpp"
#include "io/obj.hpp"
#include "io/scan_files.hpp"
#include "io/sound_file.hpp"
#include "media/video_writer.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Arrays in the clip's own unit, a piece at a time.
void write_lengths(const fs::path& path, const std::vector<std::int64_t>& shape, std::span<const float> mm, double unit) {
    NpyWriter writer(path, shape);
    std::vector<float> piece;
    for (std::size_t at = 0; at < mm.size(); at += piece.size()) {
        piece.assign(mm.begin() + std::ptrdiff_t(at), mm.begin() + std::ptrdiff_t(std::min(mm.size(), at + (1 << 18))));
        if (unit != 1)
            for (float& value : piece) value = static_cast<float>(value / unit);
        writer.write(piece);
    }
    writer.commit();
}

Result<void> write_texture(const fs::path& folder, const Clip& clip, const WriteOptions& options, Json& json) {
    if (!clip.texture) return {};
    const std::int64_t frames = clip.texture->frames() == 1 ? 1 : std::min(clip.texture->frames(), clip.frame_count());
    const char* name = frames == 1 ? "texture.png" : options.texture_video ? "texture.mkv" : "texture";
    json["texture"] = name;
    std::optional<media::VideoWriter> video;
    if (frames > 1 && options.texture_video)
        video = media::VideoWriter::lossless(folder / name, clip.texture->width(), clip.texture->height(), clip.frame_rate);
    else if (frames > 1)
        fs::create_directory(folder / name);
    for (std::int64_t f = 0; f < frames; ++f) {
        MIEN_TRY(image, clip.texture->read(f));
        if (video) video->write(image);
        else write_image(frames == 1 ? folder / name : folder / name / fmt::format("{:06}.png", f), image);
        if (options.progress) options.progress("writing texture", f + 1, frames);
    }
    if (video) video->finish();
    return {};
}

void write_motion(const fs::path& folder, const Clip& clip, Json& json) {
    const double unit = millimetres(clip.unit);
    const auto sequence = [&](const char* key, const std::optional<PointSequence>& points) {
        if (!points) return;
        const std::string name = std::string(key) + ".npy";
        write_lengths(folder / name, {points->frames, points->points, 3}, points->xyz, unit);
        json[key] = name;
    };
    sequence("vertices", clip.vertices);
    sequence("markers", clip.markers);
    if (clip.weights) {
        const WeightSequence& weights = *clip.weights;
        write_npy(folder / "weights.npy", {weights.frames, weights.count}, weights.values);
        json["weights"] = "weights.npy";
    }
    if (!clip.head_pose.empty()) {
        std::vector<float> values;
        for (const RigidPose& pose : clip.head_pose) {
            const auto& q = pose.rotation;
            for (const float value : {q.w(), q.x(), q.y(), q.z()}) values.push_back(value);
            for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(pose.translation[axis] / unit));
        }
        write_npy(folder / "head_pose.npy", {std::int64_t(clip.head_pose.size()), 7}, values);
        json["head_pose"] = "head_pose.npy";
    }
    if (!clip.gaze.empty()) {
        std::vector<float> values;
        for (const Gaze& gaze : clip.gaze)
            for (int eye = 0; eye < 2; ++eye) {
                values.push_back(gaze.yaw[eye]);
                values.push_back(gaze.pitch[eye]);
            }
        write_npy(folder / "gaze.npy", {std::int64_t(clip.gaze.size()), 4}, values);
        json["gaze"] = "gaze.npy";
    }
}

/// A site on a triangle is written by the triangle's index and weights in the triangle's order, one at a vertex by the
/// vertex, in a row that NaN fills up.
Result<void> write_sites(const fs::path& path, const Clip& clip) {
    const auto sorted = [](Triangle t) {
        std::sort(t.begin(), t.end());
        return t;
    };
    std::map<Triangle, std::size_t> triangle_of;
    if (clip.neutral)
        for (std::size_t t = 0; t < clip.neutral->triangles.size(); ++t) triangle_of.try_emplace(sorted(clip.neutral->triangles[t]), t);
    const auto at_vertex = [](const Site& site) { return site.vertices[0] == site.vertices[1] && site.vertices[1] == site.vertices[2]; };
    const auto M = std::int64_t(clip.marker_sites.size());
    if (std::all_of(clip.marker_sites.begin(), clip.marker_sites.end(), at_vertex)) {
        std::vector<float> vertices;
        for (const Site& site : clip.marker_sites) vertices.push_back(static_cast<float>(site.vertices[0]));
        write_npy(path, {M}, vertices);
        return {};
    }
    std::vector<float> rows;
    for (const Site& site : clip.marker_sites) {
        const auto& v = site.vertices;
        if (at_vertex(site)) {
            rows.push_back(static_cast<float>(v[0]));
            rows.insert(rows.end(), 3, std::numeric_limits<float>::quiet_NaN());
            continue;
        }
        const auto at = triangle_of.find(sorted({v[0], v[1], v[2]}));
        if (at == triangle_of.end())
            return Error{ErrorCode::invalid, fmt::format("marker {} sits between vertices {}, {} and {}, which are no triangle of the mesh", rows.size() / 4, v[0], v[1], v[2])};
        rows.push_back(static_cast<float>(at->second));
        for (const std::uint32_t corner : clip.neutral->triangles[at->second])
            for (int i = 0; i < 3; ++i)
                if (v[i] == corner) rows.push_back(site.weights[i]);
    }
    write_npy(path, {M, 4}, rows);
    return {};
}

Result<void> write_statics(const fs::path& folder, const Clip& clip, Json& json) {
    const double unit = millimetres(clip.unit);
    if (clip.neutral) {
        write_obj(folder / "neutral.obj", *clip.neutral, unit);
        json["neutral"] = "neutral.obj";
    }
    if (!clip.marker_sites.empty()) {
        MIEN_CHECK(write_sites(folder / "marker_sites.npy", clip));
        json["marker_sites"] = "marker_sites.npy";
    }
    if (!clip.blendshapes.empty()) {
        const std::int64_t V = clip.blendshapes[0].offsets.rows();
        NpyWriter writer(folder / "blendshapes.npy", {std::int64_t(clip.blendshapes.size()), V, 3});
        Json names = Json::array();
        for (const Blendshape& shape : clip.blendshapes) {
            const Points offsets = (shape.offsets.cast<double>() / unit).cast<float>();
            writer.write({offsets.data(), std::size_t(offsets.size())});
            names.push_back(shape.name);
        }
        writer.commit();
        json["blendshapes"] = {{"offsets", "blendshapes.npy"}, {"names", names}};
    }
    if (clip.weights && !clip.weights->names.empty()) json["weight_names"] = clip.weights->names;
    if (!clip.rigid.empty()) {
        write_npy(folder / "rigid.npy", {std::int64_t(clip.rigid.size())}, std::vector<float>(clip.rigid.begin(), clip.rigid.end()));
        json["rigid"] = "rigid.npy";
    }
    if (clip.mask) {
        write_image(folder / "mask.png", *clip.mask);
        json["masks"] = "mask.png";
    }
    if (clip.sound) {
        write_wav(folder / "sound.wav", *clip.sound);
        json["sound"] = "sound.wav";
    }
    return {};
}

/// One key a line, its value on the same line.
std::string text_of(const Json& json) {
    std::string text = "{";
    for (const auto& [key, value] : json.items()) text += fmt::format("{}\n  {}: {}", text == "{" ? "" : ",", Json(key).dump(), value.dump());
    return text + "\n}\n";
}

/// Moves what was staged into place, clip.json last; what it replaces is kept until then. Without `replace` nothing is: what has
/// come there meanwhile stays.
void move_into_place(const fs::path& staged, const fs::path& target, bool replace) {
    const auto whole = keep_unfinished();
    std::error_code error;
    fs::create_directories(target, error);
    if (error) cannot_write(target, error.value());
    std::vector<fs::path> names;
    for (const auto& entry : fs::directory_iterator(staged))
        if (entry.path().filename() != "clip.json") names.push_back(entry.path().filename());
    names.emplace_back("clip.json");
    const fs::path old = staged / ".replaced";
    fs::create_directory(old, error);
    if (error) cannot_write(target, error.value());
    std::vector<fs::path> moved, replaced;
    for (const fs::path& name : names) {
        if (replace && fs::exists(fs::symlink_status(target / name))) {
            fs::rename(target / name, old / name, error);
            if (!error) replaced.push_back(name);
        }
        if (!error) error = rename_path(staged / name, target / name, false);
        if (!error) {
            moved.push_back(name);
            continue;
        }
        // Put everything back as it was.
        std::error_code ignored;
        for (const fs::path& back : moved) fs::rename(target / back, staged / back, ignored);
        for (const fs::path& back : replaced) fs::rename(old / back, target / back, ignored);
        cannot_write(target / name, error.value());
    }
}

}  // namespace

Result<void> write_clip(const fs::path& path, const Clip& clip, const WriteOptions& options) {
    const fs::path target = fs::absolute(path.has_filename() ? path : path.parent_path()).lexically_normal();
    std::error_code error;
    if (fs::exists(target, error)) {
        if (!fs::is_directory(target, error)) throw EnvironmentError(fmt::format("{} is a file; name a folder for the clip", target.string()));
        if (!fs::is_empty(target, error) && !options.overwrite)
            throw EnvironmentError(fmt::format("{} is not empty; name another folder, or overwrite it with -y", target.string()));
    }
    fs::create_directories(target.parent_path(), error);
    if (error) cannot_write(target, error.value());
    const Unfinished staging(target, Unfinished::Kind::folder);
    Json json;
    if (clip.frame_rate.den == 1) json["fps"] = clip.frame_rate.num;
    else json["fps"] = to_string(clip.frame_rate);
    json["unit"] = name_of(clip.unit);
    MIEN_CHECK(write_statics(staging.path(), clip, json));
    write_motion(staging.path(), clip, json);
    MIEN_CHECK(write_texture(staging.path(), clip, options, json));
    if (clip.scans) {
        MIEN_CHECK(write_scans(staging.path(), *clip.scans, std::min(clip.scans->frames(), clip.frame_count()), millimetres(clip.unit), options.progress));
        for (const char* key : {"positions_medium", "positions_fine", "albedo"})
            if (key != std::string("albedo") || clip.scans->has_albedo()) json[key] = key;
    }
    for (const Take& take : clip.takes) json["takes"].push_back({{"name", take.name}, {"first", take.first}});
    write_file(staging.path() / "clip.json", text_of(json));
    move_into_place(staging.path(), target, options.overwrite);
    return {};
}

}  // namespace mien::io
