#include "io/clip_description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/frame_rate.hpp"
#include "io/fault_list.hpp"
#include "io/file.hpp"
#include "io/live_link.hpp"
#include "io/marker_file.hpp"
#include "io/npy.hpp"
#include "io/number_table.hpp"
#include "io/numbered_files.hpp"
#include "io/text.hpp"
#include "io/texture_file.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Takes the keys of clip.json one by one, so that what is left over is unknown.
class Keys {
public:
    Keys(Json json, fs::path folder, Findings& findings) : json_(std::move(json)), folder_(std::move(folder)), findings_(findings) {}

    std::optional<Json> take(const char* key) {
        const auto at = json_.find(key);
        if (at == json_.end()) return std::nullopt;
        Json value = std::move(*at);
        json_.erase(at);
        if (value.is_null()) return std::nullopt;
        return value;
    }
    /// A path inside the folder; nothing (and a finding) for one that leads out of it.
    std::optional<fs::path> path(const char* key, const Json& value) {
        if (!value.is_string()) {
            problem(key, "is not a file name in quotes");
            return std::nullopt;
        }
        const fs::path named = fs::path(value.get<std::string>()).lexically_normal();
        if (named.empty() || named.string().find('\0') != std::string::npos) {
            problem(key, "is an empty file name");
            return std::nullopt;
        }
        // clip.json may come from a stranger: it must not make us read files all over the machine.
        if (named.is_absolute() || *named.begin() == "..") {
            problem(key, fmt::format("leads out of the clip folder ({}); put the file, or a symbolic link to it, inside", named.string()));
            return std::nullopt;
        }
        return folder_ / named;
    }
    std::optional<fs::path> take_path(const char* key) {
        const auto value = take(key);
        return value ? path(key, *value) : std::nullopt;
    }
    /// An array of numbers or of rows of numbers, or a file's name.
    ClipDescription::Numbers take_numbers(const char* key) {
        ClipDescription::Numbers numbers;
        const auto value = take(key);
        if (!value) return numbers;
        if (!value->is_array()) {
            numbers.file = path(key, *value);
            return numbers;
        }
        IndexRanges wrong;
        for (const Json& entry : *value) {
            std::vector<double> row;
            bool good = true;
            for (const Json& number : entry.is_array() ? entry : Json::array({entry})) {
                if (number.is_number()) row.push_back(number.get<double>());
                else good = false;
            }
            if (!good) wrong.add(std::int64_t(numbers.rows.size()));
            numbers.rows.push_back(std::move(row));
        }
        if (wrong.empty()) return numbers;
        problem(key, wrong.subject("entry", "entries") + " not a number or a row of numbers");
        return {};
    }
    void problem(const char* key, std::string_view what) {
        findings_.problem(ErrorCode::invalid, fmt::format("clip.json: \"{}\" {}", key, what));
        unread_.insert(key);
    }
    std::set<std::string> unread() const { return unread_; }
    void warn_of_the_rest() {
        for (const auto& [key, value] : json_.items())
            findings_.warn(fmt::format("clip.json: the key \"{}\" is unknown and ignored", key.substr(0, 60)));
    }

private:
    Json json_;
    fs::path folder_;
    Findings& findings_;
    std::set<std::string> unread_;
};

ClipDescription::Targets take_targets(Keys& keys) {
    ClipDescription::Targets targets;
    const char* key = "blendshapes";
    const auto value = keys.take(key);
    if (!value) return targets;
    if (value->is_array()) {
        for (const Json& entry : *value) targets.meshes.push_back(entry.is_null() ? fs::path() : keys.path(key, entry).value_or(fs::path()));
    } else if (value->is_object()) {
        if (value->contains("offsets")) targets.file = keys.path(key, (*value)["offsets"]);
        else keys.problem(key, "lacks \"offsets\"");
        if (value->contains("names")) {
            if ((*value)["names"].is_array()) {
                for (const Json& name : (*value)["names"]) targets.names.push_back(name.is_string() ? name.get<std::string>() : "");
            } else if (const auto file = keys.path(key, (*value)["names"])) {
                const auto text = read_text(*file);
                if (!text) keys.problem(key, text.error().message);
                else {
                    Lines lines(*text);
                    for (std::string_view line; lines.next(line);)
                        if (!trimmed(line).empty()) targets.names.emplace_back(trimmed(line));
                }
            }
        }
    } else {
        targets.file = keys.path(key, *value);
    }
    return targets;
}

/// [{"name": "smile", "first": 0}, ...], ascending from frame 0.
std::vector<Take> take_takes(Keys& keys) {
    std::vector<Take> takes;
    FaultList faults;
    const char* key = "takes";
    const auto value = keys.take(key);
    if (!value) return takes;
    std::int64_t i = -1;
    for (const Json& entry : value->is_array() ? *value : Json::array({*value})) {
        ++i;
        if (!entry.is_object() || !entry.contains("first") || !entry["first"].is_number_integer()) {
            faults.add(fmt::format("entry {} lacks \"first\", the take's first frame", i));
            continue;
        }
        const auto first = entry["first"].get<std::int64_t>();
        if (i == 0 && first != 0) faults.add("must begin with frame 0");
        if (!takes.empty() && first <= takes.back().first) faults.add(fmt::format("must ascend, but frame {} follows {}", first, takes.back().first));
        takes.push_back({entry.value("name", Json("")).is_string() ? entry.value("name", Json("")).get<std::string>() : "", first});
    }
    if (faults.empty()) return takes;
    keys.problem(key, faults.error().message);
    return {};
}

std::optional<Rational> take_rate(Keys& keys) {
    const auto value = keys.take("fps");
    if (!value) return std::nullopt;
    std::string text;
    if (value->is_string()) text = value->get<std::string>();
    else if (value->is_number_integer()) text = value->dump();
    // 29.97 is what the file says; the shortest text of the double says it again.
    else if (value->is_number()) text = fmt::format("{:f}", value->get<double>());
    const auto rate = parse_frame_rate(text);
    if (rate) return *rate;
    keys.problem("fps", rate.error().message);
    return std::nullopt;
}

std::optional<Unit> take_unit(Keys& keys) {
    const auto value = keys.take("unit");
    if (!value) return std::nullopt;
    for (const Unit unit : {Unit::mm, Unit::cm, Unit::m})
        if (*value == name_of(unit)) return unit;
    keys.problem("unit", "is not mm, cm or m");
    return std::nullopt;
}

/// What kind of recording a file is, for folders and files without clip.json.
void place_recording(const fs::path& path, ClipDescription& description, Findings& findings) {
    const std::string ending = lower_case(path.extension().string()), stem = lower_case(path.stem().string());
    std::optional<fs::path>* place = nullptr;
    const auto unreadable = [&](Error error) {
        findings.problem(std::move(error));
        description.unread.insert({"vertices", "markers", "weights"});  // it may hold any of them
    };
    if (ending == ".trc" || ending == ".c3d") {
        place = &description.markers;
    } else if (ending == ".npy") {
        // Names first, since three dimensions are vertices as well as markers.
        if (stem == "vertices") place = &description.vertices;
        else if (stem == "weights") place = &description.weights;
        else if (stem == "markers") place = &description.markers;
        else if (stem == "head_pose") place = &description.head_pose;
        else if (stem == "gaze") place = &description.gaze;
        else {
            const auto array = read_npy_shape(path);
            if (!array) return unreadable(array.error());
            if (array->size() == 3 && (*array)[2] == 3)
                place = (*array)[1] > 2000 ? &description.vertices : &description.markers;
            else if (array->size() == 2)
                place = &description.weights;
        }
    } else if (ending == ".csv") {
        const auto text = read_text(path);
        if (!text) return unreadable(text.error());
        if (is_live_link(*text) || stem == "weights") place = &description.weights;
        else if (stem == "markers") place = &description.markers;
        else if (const auto table = parse_number_table(*text)) place = names_markers(*table) ? &description.markers : &description.weights;
        else return unreadable(in_file(path, table.error()));
    }
    if (!place) return findings.warn(fmt::format("{} is not used: nothing tells what it holds", path.string()));
    if (*place) return findings.warn(fmt::format("{} is not used: {} is taken already", path.string(), (*place)->string()));
    *place = path;
}

std::optional<fs::path> only_file(const fs::path& folder, const std::vector<std::string>& endings, const char* what, Findings& findings) {
    std::vector<fs::path> found;
    for (const auto& set : find_numbered(folder, endings)) found.insert(found.end(), set.paths.begin(), set.paths.end());
    if (found.empty()) return std::nullopt;
    std::sort(found.begin(), found.end());
    if (found.size() > 1) findings.warn(fmt::format("{} files could be the {}; {} is taken", found.size(), what, found[0].filename().string()));
    return found[0];
}

void guess_folder(const fs::path& folder, ClipDescription& description, Findings& findings) {
    for (const char* ending : {".obj", ".ply", ".glb"})
        for (const char* stem : {"neutral", "head", "face"})
            if (const fs::path path = folder / (std::string(stem) + ending); fs::exists(path) && !description.neutral)
                description.neutral = path;

    std::vector<fs::path> recordings;
    for (const auto& set : find_numbered(folder, {".npy", ".csv", ".trc", ".c3d"}))
        recordings.insert(recordings.end(), set.paths.begin(), set.paths.end());
    std::sort(recordings.begin(), recordings.end());
    for (const fs::path& path : recordings) place_recording(path, description, findings);

    const auto frames_of = [&](const NumberedFiles& files) -> std::vector<fs::path> {
        auto set = one_per_number(files);
        if (!set) return findings.problem(set.error()), std::vector<fs::path>{};
        if (set->fault) findings.problem(*set->fault);
        return std::move(set->paths);
    };
    for (const auto& set : find_numbered(folder, {".obj", ".ply", ".glb", ".gltf"})) {
        if (set.paths.size() == 1 && description.neutral == set.paths[0]) continue;
        // A single mesh beside a recording is its neutral; numbered meshes are the recording.
        const bool has_vertices = description.vertices || !description.vertex_files.empty();
        const bool recorded = has_vertices || description.markers || description.weights;
        if (set.paths.size() == 1 && recorded && !description.neutral) {
            description.neutral = set.paths[0];
        } else if (has_vertices) {
            findings.warn(fmt::format("{} is not used: there are vertices already", (folder / set.pattern).string()));
        } else {
            description.vertex_files = frames_of(set);
            if (description.vertex_files.empty()) description.unread.insert("vertices");
        }
    }

    const auto pictures = find_numbered(folder, image_endings());
    description.texture = only_file(folder, video_endings(), "texture", findings);
    if (!pictures.empty() && (pictures[0].paths.size() > 1 || !description.texture)) {
        if (pictures.size() > 1 && pictures[1].paths.size() == pictures[0].paths.size())
            findings.warn(fmt::format("several pictures could be the texture; {} is taken", pictures[0].pattern));
        if (description.texture)
            findings.warn(fmt::format("{} is not used: the texture is {}", description.texture->string(), pictures[0].pattern));
        description.texture.reset();
        description.texture_files = frames_of(pictures[0]);
    }
    description.sound = only_file(folder, {".wav", ".flac"}, "sound", findings);
}

}  // namespace

std::optional<ClipDescription> parse_description(std::string_view json, const fs::path& folder, Findings& findings) {
    ClipDescription description;
    if (json.starts_with("\xef\xbb\xbf")) json.remove_prefix(3);
    // Deep nesting would exhaust the stack inside the parser.
    int depth = 0, deepest = 0;
    for (const char c : json) {
        depth += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
        deepest = std::max(deepest, depth);
    }
    Json parsed;
    if (deepest <= 64) {
        try {
            parsed = Json::parse(json);
        } catch (const Json::exception& error) {
            // "[json.exception.parse_error.101] parse error at line 1, ...": the brackets are for programmers.
            std::string_view why = error.what();
            if (const std::size_t end = why.find("] "); end != std::string_view::npos) why.remove_prefix(end + 2);
            findings.problem(ErrorCode::damaged, fmt::format("clip.json is not JSON: {}", why));
            return std::nullopt;
        }
    }
    if (!parsed.is_object()) {
        findings.problem(ErrorCode::damaged, "clip.json is not a JSON object { \"fps\": ... }");
        return std::nullopt;
    }
    Keys keys(std::move(parsed), folder, findings);
    description.frame_rate = take_rate(keys);
    description.unit = take_unit(keys);
    description.neutral = keys.take_path("neutral");
    description.vertices = keys.take_path("vertices");
    description.markers = keys.take_path("markers");
    description.weights = keys.take_path("weights");
    description.head_pose = keys.take_path("head_pose");
    description.gaze = keys.take_path("gaze");
    description.texture = keys.take_path("texture");
    description.sound = keys.take_path("sound");
    description.rigid = keys.take_numbers("rigid");
    description.marker_sites = keys.take_numbers("marker_sites");
    description.blendshapes = take_targets(keys);
    if (const auto masks = keys.take("masks")) {
        for (const Json& mask : masks->is_array() ? *masks : Json::array({*masks}))
            if (const auto path = keys.path("masks", mask)) description.masks.push_back(*path);
    }
    description.positions_medium = keys.take_path("positions_medium");
    description.positions_fine = keys.take_path("positions_fine");
    description.albedo = keys.take_path("albedo");
    description.takes = take_takes(keys);
    if (const auto names = keys.take("weight_names")) {
        if (names->is_array())
            for (const Json& name : *names) description.weight_names.push_back(name.is_string() ? name.get<std::string>() : "");
        else keys.problem("weight_names", "is not a list of names");
    }
    keys.warn_of_the_rest();
    description.unread = keys.unread();
    return description;
}

ClipDescription guess_description(const fs::path& path, Findings& findings) {
    ClipDescription description;
    if (fs::is_directory(path)) {
        guess_folder(path, description, findings);
        return description;
    }
    const std::string ending = lower_case(path.extension().string());
    if (ending == ".obj" || ending == ".ply" || ending == ".glb" || ending == ".gltf") description.vertices = path;
    else place_recording(path, description, findings);
    return description;
}

}  // namespace mien::io
