#include "io/clip_folder.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/clip.hpp"
#include "io/clip_reader.hpp"
#include "io/file.hpp"
#include "io/text.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

constexpr Rational kUnsetRate{30, 1};

/// NPY files hold numbers alone; others may bring a frame rate or a mesh.
bool tells_nothing_else(const std::optional<fs::path>& path) { return path && lower_case(path->extension().string()) == ".npy"; }

}  // namespace

ClipReading ClipReader::read() {
    if (!describe()) return std::move(reading_);
    read_vertices();
    note_unread("vertices", description_.vertices || !description_.vertex_files.empty(), clip_.vertices.has_value());
    read_markers_file();
    note_unread("markers", description_.markers.has_value(), clip_.markers.has_value());
    read_neutral();
    // The first mesh of a sequence may stand for it.
    const bool of_sequence = unread("vertices") && !tells_nothing_else(description_.vertices);
    note_unread("neutral", description_.neutral || of_sequence, clip_.neutral.has_value());
    read_weights();
    note_unread("weights", description_.weights.has_value(), clip_.weights.has_value());
    read_blendshapes();
    read_sites();
    read_rigid();
    read_pose_and_gaze();
    read_texture();
    read_sound_file();
    settle_rate();
    settle_unit();
    read_scans();
    sources_.unit_asked = options_.unit.has_value();
    validate(clip_, sources_, findings_);
    return std::move(reading_);
}

bool ClipReader::describe() {
    std::error_code error;
    fs::path path = path_;
    if (path.filename() == "clip.json") path = path.parent_path().empty() ? fs::path(".") : path.parent_path();
    if (!fs::exists(path, error)) {
        problem(ErrorCode::missing, fmt::format("there is no clip {}", path.string()));
        return false;
    }
    const fs::path full = fs::weakly_canonical(path, error);
    clip_.name = (fs::is_directory(path, error) ? full.filename() : full.stem()).string();
    if (fs::is_directory(path, error) && fs::exists(path / "clip.json", error)) {
        const auto json = take(read_text(path / "clip.json", 64 << 20));
        if (!json) return false;
        auto description = parse_description(*json, path, findings_);
        if (!description) return false;
        description_ = std::move(*description);
    } else {
        description_ = guess_description(path, findings_);
        guessed_ = true;
    }
    sources_.unread = description_.unread;
    if (options_.frame_rate) {
        sources_.unread.erase("fps");
        if (description_.frame_rate && *description_.frame_rate != *options_.frame_rate)
            findings_.warn(fmt::format("clip.json says {} frames a second, but the asked {} count", to_string(*description_.frame_rate), to_string(*options_.frame_rate)));
        description_.frame_rate = options_.frame_rate;
    }
    if (options_.unit) {
        sources_.unread.erase("unit");
        if (description_.unit && *description_.unit != *options_.unit)
            findings_.warn(fmt::format("clip.json says its unit is {}, but the asked {} counts", name_of(*description_.unit), name_of(*options_.unit)));
        description_.unit = options_.unit;
    }
    return true;
}

std::string ClipReader::how_to_set(const char* key, const std::string& value) const {
    std::error_code ignored;
    if (fs::is_directory(path_, ignored) || path_.filename() == "clip.json")
        return fmt::format("to set it, write \"{}\": {} into {}", key, value, guessed_ ? "a clip.json in the folder" : "clip.json");
    const fs::path folder = path_.parent_path().empty() ? fs::path(".") : path_.parent_path();
    if (fs::exists(folder / "clip.json", ignored)) return fmt::format("{} may tell: name the folder {} instead of the file", (folder / "clip.json").string(), folder.string());
    return fmt::format("to set it, give --{} where the command has it, or make a clip folder", key);
}

void ClipReader::settle_rate() {
    for (std::size_t i = 0; i < rates_.size() && !unread("fps"); ++i) {
        const auto& [name, rate] = rates_[i];
        const Rational used = description_.frame_rate ? *description_.frame_rate : rates_[0].second;
        if (std::abs(rate.value() / used.value() - 1) > 1e-3)
            findings_.warn(fmt::format("{} was recorded at {} frames a second, but {} counts", name, to_string(rate), to_string(used)));
    }
    if (description_.frame_rate) clip_.frame_rate = *description_.frame_rate;
    else if (!rates_.empty()) clip_.frame_rate = rates_[0].second;
    else {
        clip_.frame_rate = kUnsetRate;
        if ((unread("markers") && !tells_nothing_else(description_.markers)) || (unread("weights") && !tells_nothing_else(description_.weights)))
            sources_.unread.insert("fps");
        if (!unread("fps")) findings_.warn("nothing tells the frame rate, so 30 is taken; " + how_to_set("fps", "30"));
    }
}

void ClipReader::settle_unit() {
    if (description_.unit) {
        clip_.unit = *description_.unit;
    } else {
        const auto size = head_size(clip_);  // still in file units
        // Markers that tell their own unit decide when they are all there is.
        const bool markers_tell = marker_unit_ && !clip_.neutral && !clip_.vertices;
        const auto guess = markers_tell ? marker_unit_ : size ? plausible_unit(*size) : std::nullopt;
        clip_.unit = guess.value_or(Unit::mm);
        if (unread("neutral") || (!clip_.neutral && (unread("vertices") || (!clip_.vertices && unread("markers"))))) sources_.unread.insert("unit");
        if (!unread("unit") && !markers_tell && (clip_.neutral || clip_.vertices || clip_.markers))
            findings_.warn(fmt::format("nothing tells the unit; {} {} is taken; {}", size ? fmt::format("the head is {:.3g} large, so", *size) : "too few points show the head's size, so", name_of(clip_.unit),
                                       how_to_set("unit", fmt::format("\"{}\"", name_of(clip_.unit)))));
    }
    const auto scale = static_cast<float>(millimetres(clip_.unit));
    const auto marker_scale = static_cast<float>(millimetres(marker_unit_.value_or(clip_.unit)));
    if (clip_.markers && marker_scale != 1)
        for (float& value : clip_.markers->xyz) value *= marker_scale;
    if (scale == 1) return;
    if (clip_.neutral) clip_.neutral->positions *= scale;
    if (clip_.vertices)
        for (float& value : clip_.vertices->xyz) value *= scale;
    for (Blendshape& shape : clip_.blendshapes) shape.offsets *= scale;
    for (RigidPose& pose : clip_.head_pose) pose.translation *= scale;
}

ClipReading read_clip(const fs::path& path, const LoadOptions& options) { return ClipReader(path, options).read(); }

Result<LoadedClip> load_clip(const fs::path& path, const LoadOptions& options) {
    ClipReading reading = read_clip(path, options);
    LoadedClip loaded;
    std::optional<Error> first;
    std::size_t others = 0;
    for (const Finding& finding : reading.findings.all()) {
        const std::string& text = finding.brief.empty() ? finding.text : finding.brief;
        if (finding.severity != Severity::problem) loaded.warnings.push_back(text);
        else if (first) ++others;
        else first = Error{finding.code, text};
    }
    if (others > 0) first->message += fmt::format(" (and {} more problem{}: 'mien check {}' lists them)", others, others == 1 ? "" : "s", path.string());
    if (first) return *first;
    loaded.clip = std::move(reading.clip);
    return loaded;
}

}  // namespace mien::io
