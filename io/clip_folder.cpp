#include "io/clip_folder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "core/parallel.hpp"
#include "io/clip_description.hpp"
#include "io/clip_validation.hpp"
#include "io/file.hpp"
#include "io/frame_times.hpp"
#include "io/image_file.hpp"
#include "io/live_link.hpp"
#include "io/marker_file.hpp"
#include "io/mesh_file.hpp"
#include "io/npy.hpp"
#include "io/number_table.hpp"
#include "io/numbered_files.hpp"
#include "io/scan_files.hpp"
#include "io/sound_file.hpp"
#include "io/text.hpp"
#include "io/texture_file.hpp"

namespace mien::io {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kMeshEndings{".obj", ".ply"};
constexpr Rational kUnsetRate{30, 1};

/// Reads one part after another into the clip. Each step reports what is wrong and leaves its part out.
class Reader {
public:
    Reader(const fs::path& path, const LoadOptions& options) : path_(path), options_(options) {}

    ClipReading read() {
        if (!describe()) return std::move(reading_);
        read_vertices();
        read_markers_file();
        read_neutral();
        read_weights();
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

private:
    /// The value, or nothing and a problem.
    template <class T>
    std::optional<T> take(Result<T> result) {
        if (result) return std::move(*result);
        findings_.problem(result.error());
        return std::nullopt;
    }
    void problem(ErrorCode code, std::string text) { findings_.problem(code, std::move(text)); }

    bool describe() {
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
            description_ = parse_description(*json, path, findings_);
        } else {
            description_ = guess_description(path, findings_);
            guessed_ = true;
        }
        if (options_.frame_rate) {
            if (description_.frame_rate && *description_.frame_rate != *options_.frame_rate)
                findings_.warn(fmt::format("clip.json says {} frames a second, but the asked {} count", to_string(*description_.frame_rate), to_string(*options_.frame_rate)));
            description_.frame_rate = options_.frame_rate;
        }
        if (options_.unit) {
            if (description_.unit && *description_.unit != *options_.unit)
                findings_.warn(fmt::format("clip.json says its unit is {}, but the asked {} counts", name_of(*description_.unit), name_of(*options_.unit)));
            description_.unit = options_.unit;
        }
        return true;
    }

    void read_vertices() {
        std::vector<fs::path> files = description_.vertex_files;
        if (description_.vertices) {
            const fs::path& path = *description_.vertices;
            sources_.vertices = path.string();
            const std::string ending = lower_case(path.extension().string());
            std::error_code ignored;
            if (ending == ".npy") {
                auto array = take(read_npy(path));
                if (!array) return;
                if (array->shape.size() == 2) array->shape.insert(array->shape.begin(), 1);
                if (array->shape.size() != 3 || array->shape[2] != 3)
                    return problem(ErrorCode::invalid, fmt::format("{} has shape {}; [frames, vertices, 3] is wanted", path.string(), array->shape_text()));
                if (array->shape[1] > kMaxVertices || array->shape[0] > kMaxFrames)
                    return problem(ErrorCode::limit_exceeded, fmt::format("{} has shape {}, more than a clip may have", path.string(), array->shape_text()));
                clip_.vertices.emplace();
                clip_.vertices->frames = array->shape[0];
                clip_.vertices->points = array->shape[1];
                clip_.vertices->xyz = std::move(array->values);
                return;
            }
            if (!fs::is_directory(path, ignored) && (fs::exists(path, ignored) || ending == ".glb" || ending == ".gltf")) {
                files = {path};
            } else {
                auto numbered = take(open_numbered(path, kMeshEndings));
                if (!numbered) return;
                files = std::move(numbered->paths);
            }
        }
        if (!files.empty()) read_mesh_sequence(files);
    }

    /// One mesh per frame. The first gives the connectivity; the others must have as many vertices.
    void read_mesh_sequence(const std::vector<fs::path>& files) {
        if (!description_.vertices) sources_.vertices = files[0].parent_path().string();
        for (const fs::path& file : files) sources_.vertex_frames.push_back(file.string());
        auto first = take(read_mesh(files[0]));
        if (!first) return;
        for (std::string& warning : first->warnings) findings_.warn(std::move(warning));
        const std::int64_t points = first->mesh.positions.rows();
        if (points == 0) return problem(ErrorCode::invalid, fmt::format("{} has no vertices", files[0].string()));
        const auto frames = std::int64_t(files.size());
        if (frames * points > kMaxValues / 3) return problem(ErrorCode::limit_exceeded, fmt::format("{} meshes are more than fits into memory", files.size()));
        clip_.vertices.emplace(frames, points);
        clip_.vertices->frame(0) = first->mesh.positions;
        std::vector<std::optional<Error>> errors(files.size());
        std::mutex progress_mutex;
        std::int64_t done = 1;
        parallel_for(frames - 1, [&](std::int64_t i) {
            const std::int64_t f = i + 1;
            const auto positions = read_positions(files[std::size_t(f)]);
            if (!positions) {
                errors[std::size_t(f)] = positions.error();
            } else if (positions->rows() != points) {
                errors[std::size_t(f)] = Error{ErrorCode::mismatch, fmt::format("{} (frame {}) has {} vertices, but {} has {}", files[std::size_t(f)].string(), f,
                                                                                positions->rows(), files[0].filename().string(), points)};
            } else {
                clip_.vertices->frame(f) = *positions;
            }
            if (options_.progress) {
                const std::lock_guard lock(progress_mutex);
                options_.progress("reading meshes", ++done, frames);
            }
        });
        std::size_t more = 0, shown = 0;
        for (const auto& error : errors) {
            if (!error) continue;
            if (shown++ < 8) findings_.problem(*error);
            else ++more;
        }
        if (more > 0) problem(ErrorCode::mismatch, fmt::format("and {} more meshes that do not fit", more));
        sequence_mesh_ = std::move(first->mesh);
        sequence_shapes_ = std::move(first->blendshapes);
    }

    void read_markers_file() {
        if (!description_.markers) return;
        sources_.markers = description_.markers->string();
        auto markers = take(read_markers(*description_.markers));
        if (!markers) return;
        if (markers->points.points > kMaxMarkers || markers->points.frames > kMaxFrames)
            return problem(ErrorCode::limit_exceeded, fmt::format("{} has more markers or frames than a clip may have", sources_.markers));
        for (const std::string& warning : markers->warnings) findings_.warn(fmt::format("{}: {}", sources_.markers, warning));
        if (markers->frame_rate) rates_.emplace_back(sources_.markers, *markers->frame_rate);
        if (markers->unit) {
            marker_unit_ = markers->unit;
            if (description_.unit && *description_.unit != *marker_unit_)
                findings_.warn(fmt::format("{} says its unit is {}, which counts for it; the clip's is {}", sources_.markers, name_of(*marker_unit_),
                                           name_of(*description_.unit)));
        }
        clip_.markers = std::move(markers->points);
    }

    void read_neutral() {
        if (description_.neutral) {
            sources_.neutral = description_.neutral->string();
            auto file = read_mesh(*description_.neutral);
            if (!file) {
                // A recording loads without a model that merely lies beside it, as one of compressed geometry.
                const std::string ending = lower_case(description_.neutral->extension().string());
                if (guessed_ && (ending == ".glb" || ending == ".gltf")) findings_.warn(file.error().message + "; it is not used");
                else findings_.problem(file.error());
                return;
            }
            for (std::string& warning : file->warnings) findings_.warn(std::move(warning));
            if (file->mesh.positions.rows() == 0) return problem(ErrorCode::invalid, fmt::format("{} has no vertices", sources_.neutral));
            clip_.neutral = std::move(file->mesh);
            sequence_shapes_ = std::move(file->blendshapes);
        } else if (sequence_mesh_) {
            sources_.neutral = sources_.vertex_frames[0];
            clip_.neutral = std::move(*sequence_mesh_);
            if (clip_.vertices->frames > 1)
                findings_.note(fmt::format("no neutral mesh is named; {} stands for it", fs::path(sources_.neutral).filename().string()));
        } else if (clip_.vertices) {
            findings_.warn("no neutral mesh is named: without its triangles the vertices are a cloud of points");
        }
    }

    void read_weights() {
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
            if (seconds > 0) rates_.emplace_back(sources_.weights, usual_rate(double(table->rows - 1) / seconds));
        }
        if (columns.empty() || std::int64_t(columns.size()) > kMaxWeights)
            return problem(ErrorCode::invalid, fmt::format("{} has {} weights a frame; 1 to {} are possible", sources_.weights, columns.size(), kMaxWeights));
        weights = WeightSequence(table->rows, std::int64_t(columns.size()));
        for (std::int64_t f = 0; f < table->rows; ++f)
            for (std::size_t i = 0; i < columns.size(); ++i) weights.frame(f)[i] = table->at(f, columns[i]);
        if (!table->names.empty())
            for (const std::int64_t c : columns) weights.names.push_back(table->names[std::size_t(c)]);
        if (!description_.weight_names.empty()) {
            if (description_.weight_names.size() != columns.size())
                problem(ErrorCode::mismatch, fmt::format("clip.json has {} weight_names, but {} has {} weights", description_.weight_names.size(), sources_.weights, columns.size()));
            else weights.names = description_.weight_names;
        }
        clip_.weights = std::move(weights);
    }

    void use_live_link(const std::string& text, const fs::path& path) {
        auto take_result = parse_live_link(text);
        if (!take_result) return findings_.problem(in_file(path, take_result.error()));
        LiveLinkTake& recording = *take_result;
        rates_.emplace_back(sources_.weights, recording.frame_rate);
        if (!recording.dropped.empty()) {
            std::string frames;
            for (std::size_t i = 0; i < std::min<std::size_t>(recording.dropped.size(), 8); ++i)
                frames += fmt::format("{}{}", i ? ", " : "", recording.dropped[i]);
            findings_.warn(fmt::format("{}: {} dropped frames were filled by interpolation ({}{}); {} rows are {} frames", sources_.weights,
                                       recording.dropped.size(), frames, recording.dropped.size() > 8 ? ", ..." : "", recording.rows,
                                       recording.weights.frames));
        }
        if (!recording.repeated.empty())
            findings_.warn(fmt::format("{}: {} rows repeat the timecode before them and were left out, the first is row {}", sources_.weights,
                                       recording.repeated.size(), recording.repeated[0]));
        // Recorded geometry has its own pose; angles belong to a clip that is weights alone.
        const bool alone = !clip_.vertices && !clip_.markers;
        const bool moves = std::any_of(recording.head_pose.begin(), recording.head_pose.end(),
                                       [](const RigidPose& pose) { return !pose.rotation.isApprox(Eigen::Quaternionf::Identity(), 1e-6f); });
        if (alone && moves && !description_.head_pose) clip_.head_pose = std::move(recording.head_pose);
        if (!description_.gaze) clip_.gaze = std::move(recording.gaze);
        sources_.head_pose = sources_.gaze = sources_.weights;
        clip_.weights = std::move(recording.weights);
    }

    void read_blendshapes() {
        const auto& targets = description_.blendshapes;
        if (!targets.given()) {
            if (clip_.weights && !sequence_shapes_.empty()) take_own_targets();
            return;
        }
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
                if (auto shape = read_target(mesh)) shapes.push_back(std::move(*shape));
            order_by_name(std::move(shapes), path);
        } else {
            auto file = take(read_mesh(path));
            if (file) order_by_name(std::move(file->blendshapes), path);
        }
    }

    std::string target_name(const std::vector<std::string>& names, std::int64_t i) const {
        if (std::size_t(i) < names.size()) return names[std::size_t(i)];
        if (clip_.weights && std::size_t(i) < clip_.weights->names.size()) return clip_.weights->names[std::size_t(i)];
        return fmt::format("blendshape{:03}", i);
    }

    std::optional<Blendshape> read_target(const fs::path& path) {
        const auto positions = take(read_positions(path));
        if (!positions) return std::nullopt;
        if (positions->rows() != clip_.neutral->positions.rows()) {
            problem(ErrorCode::mismatch,
                    fmt::format("{} has {} vertices, but {} has {}", path.string(), positions->rows(), sources_.neutral, clip_.neutral->positions.rows()));
            return std::nullopt;
        }
        return Blendshape{path.stem().string(), *positions - clip_.neutral->positions};
    }

    void read_target_list(const std::vector<fs::path>& meshes) {
        const Eigen::Index V = clip_.neutral->positions.rows();
        for (std::size_t i = 0; i < meshes.size(); ++i) {
            if (meshes[i].empty()) clip_.blendshapes.push_back({target_name({}, std::int64_t(i)), Points::Zero(V, 3)});
            else if (auto shape = read_target(meshes[i])) clip_.blendshapes.push_back(std::move(*shape));
        }
    }

    /// Those that the neutral mesh's own file brings.
    void take_own_targets() {
        const auto named = [&](const Blendshape& shape) {
            const auto& names = clip_.weights->names;
            return std::any_of(names.begin(), names.end(), [&](const std::string& name) { return plain_name(name) == plain_name(shape.name); });
        };
        if (std::int64_t(sequence_shapes_.size()) == clip_.weights->count) clip_.blendshapes = std::move(sequence_shapes_);
        else if (std::any_of(sequence_shapes_.begin(), sequence_shapes_.end(), named)) order_by_name(std::move(sequence_shapes_), sources_.neutral);
        else
            findings_.warn(fmt::format("the {} morph targets of {} are not used: {} has {} weights, of other names", sequence_shapes_.size(), sources_.neutral,
                                       sources_.weights, clip_.weights->count));
    }

    /// A name without case and marks of any spelling ("JawOpen", "jaw_open"). ARKit's "eyeBlinkLeft" is "eyeBlink_L" in many rigs.
    static std::string plain_name(const std::string& name) {
        std::string letters;
        for (const char c : lower_case(name))
            if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) letters += c;
        for (const auto& [full, brief] : {std::pair<std::string_view, char>{"left", 'l'}, {"right", 'r'}})
            if (letters.ends_with(full)) letters = letters.substr(0, letters.size() - full.size()) + brief;
        return letters;
    }

    /// Named targets to named weights, whatever the spelling; by order when the weights have no names.
    void order_by_name(std::vector<Blendshape> shapes, const fs::path& path) {
        if (!clip_.weights || clip_.weights->names.empty()) {
            clip_.blendshapes = std::move(shapes);
            return;
        }
        std::map<std::string, std::size_t> by_name;
        for (std::size_t i = 0; i < shapes.size(); ++i) by_name[plain_name(shapes[i].name)] = i;
        std::size_t used = 0;
        CappedFindings idle(findings_, Severity::warning, ErrorCode::missing, "weights without a target");
        for (const std::string& name : clip_.weights->names) {
            const auto at = by_name.find(plain_name(name));
            if (at == by_name.end()) {
                idle.add(fmt::format("{} has no target for the weight {}, which moves nothing", path.string(), name));
                clip_.blendshapes.push_back({name, Points::Zero(clip_.neutral->positions.rows(), 3)});
            } else {
                clip_.blendshapes.push_back(shapes[at->second]);
                ++used;
            }
        }
        if (used < shapes.size()) findings_.warn(fmt::format("{} has {} targets that no weight names", path.string(), shapes.size() - used));
    }

    /// Rows of numbers, from clip.json itself or from a file.
    std::optional<std::vector<std::vector<double>>> rows_of(const ClipDescription::Numbers& numbers) {
        if (!numbers.file) return numbers.rows;
        const fs::path& path = *numbers.file;
        const auto table = take(read_number_table(path));
        if (!table) return std::nullopt;
        std::vector<std::vector<double>> rows;
        for (std::int64_t r = 0; r < table->rows; ++r) {
            rows.emplace_back();
            for (std::int64_t c = 0; c < table->columns; ++c) rows.back().push_back(table->at(r, c));
            while (!rows.back().empty() && std::isnan(rows.back().back())) rows.back().pop_back();  // a shorter row
        }
        return rows;
    }

    static bool is_index(double value, std::size_t below) { return value >= 0 && value < double(below) && value == std::floor(value); }

    void read_sites() {
        if (!description_.marker_sites.given()) return;
        const auto rows = rows_of(description_.marker_sites);
        if (!rows) return;
        if (!clip_.neutral) return problem(ErrorCode::missing, "marker_sites are places on the neutral mesh, which is not there");
        const auto V = std::size_t(clip_.neutral->positions.rows()), T = clip_.neutral->triangles.size();
        CappedFindings wrong(findings_, Severity::problem, ErrorCode::invalid, "marker sites that are no place on the mesh");
        for (std::size_t i = 0; i < rows->size(); ++i) {
            const std::vector<double>& row = (*rows)[i];
            if (row.size() == 1) {
                if (is_index(row[0], V)) clip_.marker_sites.push_back(Site::at_vertex(std::uint32_t(row[0])));
                else wrong.add(fmt::format("marker_sites: entry {} names vertex {} of {}", i, row[0], V));
            } else if (row.size() == 4) {
                const double sum = row[1] + row[2] + row[3];
                if (!is_index(row[0], T)) {
                    wrong.add(fmt::format("marker_sites: entry {} names triangle {} of {}", i, row[0], T));
                } else if (!(std::abs(sum - 1) < 1e-3)) {
                    wrong.add(fmt::format("marker_sites: the barycentric coordinates of entry {} sum up to {}, not 1", i, sum));
                } else {
                    const Triangle& t = clip_.neutral->triangles[std::size_t(row[0])];
                    clip_.marker_sites.push_back({{t[0], t[1], t[2]}, {float(row[1] / sum), float(row[2] / sum), float(row[3] / sum)}});
                }
            } else {
                wrong.add(fmt::format("marker_sites: entry {} has {} numbers; a vertex, or a triangle and three weights are wanted", i, row.size()));
            }
        }
    }

    void read_rigid() {
        if (!description_.rigid.given()) return;
        const auto rows = rows_of(description_.rigid);
        if (!rows) return;
        CappedFindings wrong(findings_, Severity::problem, ErrorCode::invalid, "entries of rigid that are no index");
        for (const auto& row : *rows)
            for (const double value : row) {
                if (is_index(value, 0xffffffffu)) clip_.rigid.push_back(std::uint32_t(value));
                else wrong.add(fmt::format("rigid: {} is no index", value));
            }
    }

    void read_pose_and_gaze() {
        if (description_.head_pose) read_pose(*description_.head_pose);
        if (!description_.gaze) return;
        sources_.gaze = description_.gaze->string();
        const auto table = take(read_number_table(*description_.gaze));
        if (!table) return;
        if (table->columns != 4)
            return problem(ErrorCode::invalid, fmt::format("{} has {} columns; yaw and pitch of the right, then of the left eye are wanted", sources_.gaze, table->columns));
        for (std::int64_t f = 0; f < table->rows; ++f)
            clip_.gaze.push_back({{table->at(f, 0), table->at(f, 2)}, {table->at(f, 1), table->at(f, 3)}});
    }

    void read_pose(const fs::path& path) {
        sources_.head_pose = path.string();
        std::int64_t frames = 0, columns = 0;
        std::vector<float> values;
        if (lower_case(path.extension().string()) == ".npy") {
            auto array = take(read_npy(path));
            if (!array) return;
            const auto& shape = array->shape;
            const bool matrices = shape.size() == 3 && shape[1] == 4 && shape[2] == 4;
            if (!matrices && !(shape.size() == 2 && shape[1] == 7))
                return problem(ErrorCode::invalid, fmt::format("{} has shape {}; [frames, 7] or [frames, 4, 4] is wanted", path.string(), array->shape_text()));
            frames = shape[0];
            columns = matrices ? 16 : 7;
            values = std::move(array->values);
        } else {
            auto table = take(read_number_table(path));
            if (!table) return;
            if (table->columns != 7)
                return problem(ErrorCode::invalid, fmt::format("{} has {} columns; qw qx qy qz tx ty tz are wanted", path.string(), table->columns));
            frames = table->rows;
            columns = 7;
            values = std::move(table->values);
        }
        CappedFindings wrong(findings_, Severity::problem, ErrorCode::invalid, "head poses that are no rigid motion");
        for (std::int64_t f = 0; f < frames; ++f) {
            const float* v = values.data() + f * columns;
            RigidPose pose;
            bool rigid;
            if (columns == 7) {
                pose.rotation = Eigen::Quaternionf(v[0], v[1], v[2], v[3]);
                rigid = std::abs(pose.rotation.norm() - 1) < 1e-2f;
                pose.translation = Vec3(v[4], v[5], v[6]);
            } else {
                const Eigen::Map<const Eigen::Matrix<float, 4, 4, Eigen::RowMajor>> matrix(v);
                const Eigen::Matrix3f rotation = matrix.topLeftCorner<3, 3>();
                rigid = (rotation * rotation.transpose() - Eigen::Matrix3f::Identity()).cwiseAbs().maxCoeff() < 1e-2f && rotation.determinant() > 0;
                pose.rotation = Eigen::Quaternionf(rotation);
                pose.translation = matrix.topRightCorner<3, 1>();
            }
            if (!rigid) wrong.add(fmt::format("{}: frame {} is no rotation and translation", path.string(), f));
            pose.rotation.normalize();
            clip_.head_pose.push_back(pose);
        }
    }

    void read_texture() {
        if (description_.texture || !description_.texture_files.empty()) {
            sources_.texture = description_.texture ? description_.texture->string() : description_.texture_files[0].string();
            auto opened = take(description_.texture ? open_texture(*description_.texture) : open_pictures(description_.texture_files));
            if (opened) {
                for (std::string& note : opened->notes) findings_.note(std::move(note));
                clip_.texture = std::move(opened->source);
            }
        }
        if (scan_masks()) return;
        for (const fs::path& path : description_.masks) {
            auto mask = take(read_image(path, 1));
            if (!mask) continue;
            if (!clip_.mask) {
                clip_.mask = std::move(*mask);
            } else if (clip_.mask->width != mask->width || clip_.mask->height != mask->height) {
                problem(ErrorCode::mismatch, fmt::format("{} is {} x {}, but the first mask is {} x {}", path.string(), mask->width, mask->height,
                                                         clip_.mask->width, clip_.mask->height));
            } else {
                for (std::size_t i = 0; i < mask->pixels.size(); ++i) clip_.mask->pixels[i] = std::max(clip_.mask->pixels[i], mask->pixels[i]);
            }
        }
    }

    /// The folder or pattern of numbered masks, one per frame, that `masks` names; nothing if it names pictures of the whole clip.
    std::optional<fs::path> scan_masks() const {
        std::error_code ignored;
        if (description_.masks.size() != 1) return std::nullopt;
        const fs::path& path = description_.masks[0];
        if (!fs::is_directory(path, ignored) && path.filename().string().find('%') == std::string::npos) return std::nullopt;
        return path;
    }

    /// After the unit is known: maps are scaled as they are read.
    void read_scans() {
        clip_.takes = description_.takes;
        const bool medium = description_.positions_medium.has_value(), fine = description_.positions_fine.has_value();
        if (!medium && !fine) {
            if (description_.albedo) findings_.warn("\"albedo\" is not used: there are no positions_medium and positions_fine");
            if (scan_masks()) problem(ErrorCode::mismatch, fmt::format("{} are masks of scans, but there are no positions_medium and positions_fine", description_.masks[0].string()));
            return;
        }
        if (!medium || !fine) return problem(ErrorCode::missing, fmt::format("scans need both positions_medium and positions_fine, but there is no {}", medium ? "positions_fine" : "positions_medium"));
        if (auto scans = take(open_scans({*description_.positions_medium, *description_.positions_fine, description_.albedo, scan_masks()}, millimetres(clip_.unit))))
            clip_.scans = std::move(*scans);
    }

    void read_sound_file() {
        if (!description_.sound) return;
        sources_.sound = description_.sound->string();
        auto sound = take(read_sound(*description_.sound));
        if (sound) clip_.sound = std::move(*sound);
    }

    /// What tells the reader what no file does.
    std::string how_to_set(const char* key, const std::string& value) const {
        std::error_code ignored;
        if (fs::is_directory(path_, ignored) || path_.filename() == "clip.json")
            return fmt::format("to set it, write \"{}\": {} into {}", key, value, guessed_ ? "a clip.json in the folder" : "clip.json");
        const fs::path folder = path_.parent_path().empty() ? fs::path(".") : path_.parent_path();
        if (fs::exists(folder / "clip.json", ignored)) return fmt::format("{} may tell: name the folder {} instead of the file", (folder / "clip.json").string(), folder.string());
        return fmt::format("to set it, give --{} where the command has it, or make a clip folder", key);
    }

    void settle_rate() {
        for (std::size_t i = 0; i < rates_.size(); ++i) {
            const auto& [name, rate] = rates_[i];
            const Rational used = description_.frame_rate ? *description_.frame_rate : rates_[0].second;
            if (std::abs(rate.value() / used.value() - 1) > 1e-3)
                findings_.warn(fmt::format("{} was recorded at {} frames a second, but {} counts", name, to_string(rate), to_string(used)));
        }
        if (description_.frame_rate) clip_.frame_rate = *description_.frame_rate;
        else if (!rates_.empty()) clip_.frame_rate = rates_[0].second;
        else {
            clip_.frame_rate = kUnsetRate;
            findings_.warn("nothing tells the frame rate, so 30 is taken; " + how_to_set("fps", "30"));
        }
    }

    /// All lengths to mm.
    void settle_unit() {
        if (description_.unit) {
            clip_.unit = *description_.unit;
        } else {
            const auto size = head_size(clip_);  // still in file units
            // Markers that tell their own unit decide when they are all there is.
            const bool markers_tell = marker_unit_ && !clip_.neutral && !clip_.vertices;
            const auto guess = markers_tell ? marker_unit_ : size ? plausible_unit(*size) : std::nullopt;
            clip_.unit = guess.value_or(Unit::mm);
            if (!markers_tell && (clip_.neutral || clip_.vertices || clip_.markers))
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

    fs::path path_;
    const LoadOptions& options_;
    ClipReading reading_;
    Clip& clip_ = reading_.clip;
    Findings& findings_ = reading_.findings;
    ClipDescription description_;
    ClipSources sources_;
    bool guessed_ = false;
    std::optional<Mesh> sequence_mesh_;
    std::vector<Blendshape> sequence_shapes_;
    std::optional<Unit> marker_unit_;
    std::vector<std::pair<std::string, Rational>> rates_;  ///< what files say, in order of trust
};

}  // namespace

ClipReading read_clip(const fs::path& path, const LoadOptions& options) { return Reader(path, options).read(); }

Result<LoadedClip> load_clip(const fs::path& path, const LoadOptions& options) {
    ClipReading reading = read_clip(path, options);
    LoadedClip loaded;
    for (const Finding& finding : reading.findings.all()) {
        if (finding.severity == Severity::problem) return Error{finding.code, finding.text};
        loaded.warnings.push_back(finding.text);
    }
    loaded.clip = std::move(reading.clip);
    return loaded;
}

}  // namespace mien::io
