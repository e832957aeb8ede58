#include "io/clip_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "io/file.hpp"
#include "io/frame_times.hpp"
#include "io/limits.hpp"
#include "io/live_link.hpp"
#include "io/mesh_file.hpp"
#include "io/npy.hpp"
#include "io/number_table.hpp"
#include "io/numbered_files.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

/// A name without case and marks of any spelling ("JawOpen", "jaw_open"). ARKit's "eyeBlinkLeft" is "eyeBlink_L" in many rigs.
std::string plain_name(const std::string& name) {
    std::string letters;
    for (const char c : lower_case(name))
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) letters += c;
    for (const auto& [full, brief] : {std::pair<std::string_view, char>{"left", 'l'}, {"right", 'r'}})
        if (letters.ends_with(full)) letters = letters.substr(0, letters.size() - full.size()) + brief;
    return letters;
}

}  // namespace

void ClipReader::read_weights() {
    if (!description_.weights) return;
    const fs::path& path = *description_.weights;
    sources_.weights = path.string();
    WeightSequence weights;
    if (lower_case(path.extension().string()) != ".npy") {
        const auto text = take(read_text(path));
        if (!text) return;
        if (is_live_link(*text)) return use_live_link(*text, path);
    }
    auto table = take(read_number_table(path));
    if (!table) return;
    if (table->rows == 0) return problem(ErrorCode::invalid, fmt::format("{} has no frames", sources_.weights));
    // Columns that number the rows are no weights.
    std::vector<std::int64_t> columns;
    std::optional<std::int64_t> time;
    for (std::int64_t c = 0; c < table->columns; ++c) {
        const std::string name = table->names.empty() ? "" : lower_case(table->names[std::size_t(c)]);
        if (name == "time_s" || name == "time" || name == "seconds" || name == "t") time = c;
        else if (name != "frame" && name != "frames" && name != "frame#") columns.push_back(c);
    }
    if (table->rows > 1 && time) {
        const double seconds = table->at(table->rows - 1, *time) - table->at(0, *time);
        if (const auto rate = usual_rate(double(table->rows - 1) / seconds)) rates_.emplace_back(sources_.weights, *rate);
    }
    if (columns.empty() || std::int64_t(columns.size()) > kMaxWeights)
        return problem(ErrorCode::invalid, fmt::format("{} has {} weights a frame; 1 to {} are possible", sources_.weights, columns.size(), kMaxWeights));
    weights = WeightSequence(table->rows, std::int64_t(columns.size()));
    for (std::int64_t f = 0; f < table->rows; ++f)
        for (std::size_t i = 0; i < columns.size(); ++i) weights.frame(f)[i] = table->at(f, columns[i]);
    if (!table->names.empty())
        for (const std::int64_t c : columns) weights.names.push_back(table->names[std::size_t(c)]);
    if (!description_.weight_names.empty()) {
        if (description_.weight_names.size() == columns.size()) {
            weights.names = description_.weight_names;
        } else {
            problem(ErrorCode::mismatch, fmt::format("clip.json has {} weight_names, but {} has {} weights", description_.weight_names.size(), sources_.weights, columns.size()));
            sources_.unread.insert("weight_names");
        }
    }
    clip_.weights = std::move(weights);
}

void ClipReader::use_live_link(const std::string& text, const fs::path& path) {
    auto take_result = parse_live_link(text);
    if (!take_result) return findings_.problem(in_file(path, take_result.error()));
    LiveLinkTake& recording = *take_result;
    rates_.emplace_back(sources_.weights, recording.frame_rate);
    if (!recording.dropped.empty()) {
        IndexRanges dropped;
        for (const std::int64_t frame : recording.dropped) dropped.add(frame);
        findings_.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} dropped frames were filled by interpolation ({}); {} rows are {} frames", sources_.weights, dropped.count(),
                               dropped.text(most), recording.rows, recording.weights.frames);
        });
    }
    if (!recording.repeated.empty()) {
        IndexRanges repeated;
        for (const std::int64_t row : recording.repeated) repeated.add(row);
        findings_.warn_of_list([&](std::size_t most) {
            return fmt::format("{}: {} rows repeat the timecode before them and were left out: {}", sources_.weights, repeated.count(), repeated.text(most));
        });
    }
    // Recorded geometry has its own pose; angles belong to a clip that is weights alone.
    const bool alone = !clip_.vertices && !clip_.markers;
    const bool moves = std::any_of(recording.head_pose.begin(), recording.head_pose.end(),
                                   [](const RigidPose& pose) { return !pose.rotation.isApprox(Eigen::Quaternionf::Identity(), 1e-6f); });
    if (alone && moves && !description_.head_pose) clip_.head_pose = std::move(recording.head_pose);
    if (!description_.gaze) clip_.gaze = std::move(recording.gaze);
    sources_.head_pose = sources_.gaze = sources_.weights;
    clip_.weights = std::move(recording.weights);
}

void ClipReader::read_blendshapes() {
    const auto& targets = description_.blendshapes;
    if (!targets.given()) {
        if (clip_.weights && !sequence_shapes_.empty() && !unread("blendshapes")) take_own_targets();
        return;
    }
    if (!clip_.neutral && unread("neutral")) return;
    if (!clip_.neutral) return problem(ErrorCode::missing, "blendshapes are offsets from the neutral mesh, which is not there");
    const Eigen::Index V = clip_.neutral->positions.rows();
    if (!targets.file) return read_target_list(targets.meshes);
    const fs::path& path = *targets.file;
    std::error_code ignored;
    if (lower_case(path.extension().string()) == ".npy") {
        auto array = take(read_npy(path));
        if (!array) return;
        if (array->shape.size() != 3 || array->shape[1] != V || array->shape[2] != 3)
            return problem(ErrorCode::mismatch, fmt::format("{} has shape {}; [blendshapes, {}, 3] is wanted", path.string(), array->shape_text(), V));
        if (!targets.names.empty() && std::int64_t(targets.names.size()) != array->shape[0])
            return problem(ErrorCode::mismatch, fmt::format("{} holds {} blendshapes, but there are {} names", path.string(), array->shape[0], targets.names.size()));
        for (std::int64_t i = 0; i < array->shape[0]; ++i)
            clip_.blendshapes.push_back({target_name(targets.names, i), ConstPointsMap(array->values.data() + i * V * 3, V, 3)});
    } else if (fs::is_directory(path, ignored)) {
        std::vector<fs::path> meshes;
        for (const auto& set : find_numbered(path, kMeshEndings)) meshes.insert(meshes.end(), set.paths.begin(), set.paths.end());
        std::sort(meshes.begin(), meshes.end());
        if (meshes.empty()) return problem(ErrorCode::missing, fmt::format("the folder {} has no meshes", path.string()));
        std::vector<Blendshape> shapes;
        for (const fs::path& mesh : meshes)
            shapes.push_back(read_target(mesh));
        order_by_name(std::move(shapes), path);
    } else {
        auto file = take(read_mesh(path));
        if (file) order_by_name(std::move(file->blendshapes), path);
    }
}

std::string ClipReader::target_name(const std::vector<std::string>& names, std::int64_t i) const {
    if (std::size_t(i) < names.size()) return names[std::size_t(i)];
    if (clip_.weights && std::size_t(i) < clip_.weights->names.size()) return clip_.weights->names[std::size_t(i)];
    return fmt::format("blendshape{:03}", i);
}

Blendshape ClipReader::read_target(const fs::path& path) {
    const Points& neutral = clip_.neutral->positions;
    const auto positions = take(read_positions(path));
    if (positions && positions->rows() == neutral.rows()) return {path.stem().string(), *positions - neutral};
    if (positions) problem(ErrorCode::mismatch, fmt::format("{} has {} vertices, but {} has {}", path.string(), positions->rows(), sources_.neutral, neutral.rows()));
    // It keeps its place, so that the others are not counted wrong.
    return {path.stem().string(), Points::Zero(neutral.rows(), 3)};
}

void ClipReader::read_target_list(const std::vector<fs::path>& meshes) {
    const Eigen::Index V = clip_.neutral->positions.rows();
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (meshes[i].empty()) clip_.blendshapes.push_back({target_name({}, std::int64_t(i)), Points::Zero(V, 3)});
        else clip_.blendshapes.push_back(read_target(meshes[i]));
    }
}

void ClipReader::take_own_targets() {
    const auto named = [&](const Blendshape& shape) {
        const auto& names = clip_.weights->names;
        return std::any_of(names.begin(), names.end(), [&](const std::string& name) { return plain_name(name) == plain_name(shape.name); });
    };
    if (std::int64_t(sequence_shapes_.size()) == clip_.weights->count) clip_.blendshapes = std::move(sequence_shapes_);
    else if (std::any_of(sequence_shapes_.begin(), sequence_shapes_.end(), named)) order_by_name(std::move(sequence_shapes_), sources_.neutral);
    else if (!unread("weight_names"))
        findings_.warn(fmt::format("the {} morph targets of {} are not used: {} has {} weights, of other names", sequence_shapes_.size(), sources_.neutral,
                                   sources_.weights, clip_.weights->count));
}

void ClipReader::order_by_name(std::vector<Blendshape> shapes, const fs::path& path) {
    if (!clip_.weights || clip_.weights->names.empty() || unread("weight_names")) {
        clip_.blendshapes = std::move(shapes);
        return;
    }
    std::map<std::string, std::size_t> by_name;
    for (std::size_t i = 0; i < shapes.size(); ++i) by_name[plain_name(shapes[i].name)] = i;
    std::size_t used = 0;
    std::vector<std::string> idle;
    for (const std::string& name : clip_.weights->names) {
        const auto at = by_name.find(plain_name(name));
        if (at == by_name.end()) {
            idle.push_back(name);
            clip_.blendshapes.push_back({name, Points::Zero(clip_.neutral->positions.rows(), 3)});
        } else {
            clip_.blendshapes.push_back(shapes[at->second]);
            ++used;
        }
    }
    if (!idle.empty())
        findings_.warn(fmt::format("{} has no target for the weight{} {}, which move{} nothing", path.string(), idle.size() == 1 ? "" : "s", fmt::join(idle, ", "),
                                   idle.size() == 1 ? "s" : ""));
    if (used < shapes.size()) findings_.warn(fmt::format("{} has {} targets that no weight names", path.string(), shapes.size() - used));
}

}  // namespace mien::io
