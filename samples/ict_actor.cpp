#include "samples/ict_actor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "io/file.hpp"
#include "io/npy.hpp"
#include "io/obj.hpp"
#include "io/text.hpp"
#include "samples/ict_actor_parts.hpp"
#include "samples/noise.hpp"

namespace mien::samples {
namespace {

namespace fs = std::filesystem;
constexpr float kMillimetres = 10;  // the files are in cm

/// The ICT shapes that an ARKit weight drives: the same name with a small first letter and _L, _R for the side.
std::vector<std::string> shapes_for(std::string_view arkit) {
    if (arkit == "TongueOut") return {};  // this head's tongue stays inside
    std::string name(arkit);
    name[0] = char(name[0] - 'A' + 'a');
    if (arkit == "BrowInnerUp" || arkit == "CheekPuff") return {name + "_L", name + "_R"};
    // MouthLeft, JawRight and the like move to a side; the others lie on one.
    const bool moves = arkit.starts_with("Jaw") || arkit == "MouthLeft" || arkit == "MouthRight";
    for (std::string_view side : {"Left", "Right"})
        if (!moves && arkit.ends_with(side)) return {name.substr(0, name.size() - side.size()) + '_' + side[0]};
    return {name};
}

/// Where offsets come from, whichever form the folder has.
class Shapes {
public:
    static Result<Shapes> open(const fs::path& folder, const Points& neutral_cm) {
        Shapes shapes;
        shapes.folder_ = folder;
        shapes.neutral_ = &neutral_cm;
        if (!fs::exists(folder / "expression_deltas_f32.npy")) return shapes;
        MIEN_TRY(names, io::read_text(folder / "expression_names.txt"));
        io::Lines lines(names);
        for (std::string_view line; lines.next(line);)
            if (!io::trimmed(line).empty()) shapes.names_.emplace_back(io::trimmed(line));
        MIEN_TRY(expressions, shapes.read("expression_deltas_f32.npy"));
        if (expressions.shape[0] != std::int64_t(shapes.names_.size()))
            return Error{ErrorCode::mismatch, fmt::format("{} expression names for {} expressions in {}", shapes.names_.size(),
                                                          expressions.shape[0], folder.string())};
        shapes.expressions_ = std::move(expressions);
        return shapes;
    }

    /// Offsets of one expression, V x 3 cm.
    Result<Points> expression(const std::string& name) const {
        if (!expressions_) return from_obj(name + ".obj");
        const auto found = std::find(names_.begin(), names_.end(), name);
        if (found == names_.end())
            return Error{ErrorCode::missing, fmt::format("expression_names.txt in {} has no '{}'", folder_.string(), name)};
        return Points(row(*expressions_, found - names_.begin()));
    }

    /// Sum of the first identity modes by their weights, V x 3 cm.
    Result<Points> identity(const std::vector<float>& weights) const {
        Points sum = Points::Zero(ict::kVertices, 3);
        if (weights.empty()) return sum;
        if (!expressions_) {
            for (std::size_t i = 0; i < weights.size(); ++i) {
                if (weights[i] == 0) continue;
                MIEN_TRY(mode, from_obj(fmt::format("identity{:03}.obj", i)));
                sum += weights[i] * mode;
            }
            return sum;
        }
        MIEN_TRY(modes, read("identity_deltas_first20_f32.npy"));
        if (std::int64_t(weights.size()) > modes.shape[0])
            return Error{ErrorCode::mismatch,
                         fmt::format("{} identity weights for {} identity modes", weights.size(), modes.shape[0])};
        for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * row(modes, std::int64_t(i));
        return sum;
    }

private:
    static ConstPointsMap row(const io::NpyArray& array, std::int64_t i) {
        return {array.values.data() + i * ict::kVertices * 3, ict::kVertices, 3};
    }
    Result<io::NpyArray> read(const char* name) const {
        MIEN_TRY(array, io::read_npy(folder_ / name));
        if (array.shape.size() != 3 || array.shape[1] != ict::kVertices || array.shape[2] != 3)
            return Error{ErrorCode::mismatch, fmt::format("{} is {}, not [n, {}, 3]", (folder_ / name).string(),
                                                          array.shape_text(), ict::kVertices)};
        return std::move(array);
    }
    Result<Points> from_obj(const std::string& name) const {
        MIEN_TRY(text, io::read_text(folder_ / name));
        MIEN_TRY(points, io::parse_obj_positions(text));
        if (points.rows() != ict::kVertices)
            return Error{ErrorCode::mismatch, fmt::format("{} has {} vertices, not {}", (folder_ / name).string(),
                                                          points.rows(), ict::kVertices)};
        return Points(points - *neutral_);
    }

    fs::path folder_;
    const Points* neutral_ = nullptr;
    std::vector<std::string> names_;
    std::optional<io::NpyArray> expressions_;
};

bool on_eyeball(std::uint32_t v) { return v >= ict::kEyeball[1][0] && v < ict::kEyeball[0][1]; }

}  // namespace

Result<std::unique_ptr<IctActor>> make_ict_actor(const fs::path& given, const std::vector<float>& identity) {
    fs::path folder = given;
    if (!fs::exists(folder / "generic_neutral_mesh.obj") && fs::exists(folder / "FaceXModel")) folder /= "FaceXModel";
    MIEN_TRY(file, io::read_obj(folder / "generic_neutral_mesh.obj"));
    MIEN_TRY(neutral, ict::arrange(file));
    MIEN_TRY(shapes, Shapes::open(folder, file.positions));
    MIEN_TRY(person, shapes.identity(identity));

    auto actor = std::make_unique<IctActor>();
    actor->neutral_ = std::move(neutral);
    actor->neutral_.positions += kMillimetres * person;
    std::vector<float> most(ict::kVertices, 0);
    for (std::size_t i = 0; i < kArkitCount; ++i) {
        const bool gaze = kArkitNames[i].starts_with("EyeLook");
        for (const std::string& name : shapes_for(kArkitNames[i])) {
            MIEN_TRY(offsets, shapes.expression(name));
            for (std::uint32_t v = 0; v < ict::kVertices; ++v) {
                const Vec3 by = kMillimetres * offsets.row(v).transpose();
                if (by.squaredNorm() < 1e-12f || (gaze && on_eyeball(v))) continue;
                actor->shapes_[i].push_back({v, by});
                most[v] = std::max(most[v], by.norm());
            }
        }
    }
    for (std::uint32_t v = 0; v < ict::kSkinEnd; ++v)
        if (most[v] < 0.02f) actor->rigid_.push_back(v);
    for (int side : {0, 1})
        for (std::uint32_t v = ict::kEyeball[side][0]; v < ict::kEyeball[side][1]; ++v) actor->eyeball_[side].push_back(v);
    actor->landmarks_ = ict::find_landmarks(actor->neutral_);
    return actor;
}

Points IctActor::deform(const Instant& instant) const {
    Points points = neutral_.positions;
    for (std::size_t i = 0; i < kArkitCount; ++i) {
        const float w = instant.weights[i];
        if (w == 0) continue;
        for (const Offset& offset : shapes_[i]) points.row(offset.vertex) += w * offset.by.transpose();
    }
    for (int side : {0, 1}) {
        const float yaw = instant.gaze.yaw[side], pitch = instant.gaze.pitch[side];
        if (yaw == 0 && pitch == 0) continue;
        const Eigen::Matrix3f turn =
            (Eigen::AngleAxisf(yaw, Vec3::UnitY()) * Eigen::AngleAxisf(-pitch, Vec3::UnitX())).toRotationMatrix();
        const Vec3& centre = landmarks_.eye_centre[side];
        for (std::uint32_t v : eyeball_[side]) {
            const Vec3 arm = points.row(v).transpose() - centre;
            points.row(v) = (centre + turn * arm).transpose();
        }
    }
    return points;
}

std::vector<Blendshape> IctActor::blendshapes() const {
    std::vector<Blendshape> targets;
    for (std::size_t i = 0; i < kArkitCount; ++i) {
        targets.push_back({std::string(kArkitNames[i]), Points::Zero(neutral_.vertex_count(), 3)});
        for (const Offset& offset : shapes_[i]) targets.back().offsets.row(offset.vertex) += offset.by.transpose();
    }
    return targets;
}

std::vector<float> ict_identity(std::uint64_t seed, int count) {
    if (seed == 0) return {};
    Random random(seed);
    std::vector<float> weights;
    for (int i = 0; i < count; ++i) weights.push_back(0.7f * std::clamp(random.normal(), -2.f, 2.f));
    return weights;
}

}  // namespace mien::samples
